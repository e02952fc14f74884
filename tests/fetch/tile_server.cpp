// SPDX-License-Identifier: Apache-2.0
// Serves one picture as every tile, fast enough that the client is what is measured. Prints its port.
// Usage: fetch_tile_server PICTURE THREADS

#include <httplib.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  std::ifstream in(argv[1], std::ios::binary);
  const std::string picture{std::istreambuf_iterator<char>(in), {}};
  const auto threads = static_cast<std::size_t>(std::stoi(argv[2]));
  httplib::Server server;
  server.new_task_queue = [threads] { return new httplib::ThreadPool(threads); };
  server.set_keep_alive_max_count(100000000);
  server.set_tcp_nodelay(true);
  server.Get(R"(/\d+/\d+/\d+)", [&](const httplib::Request&, httplib::Response& response) {
    response.set_header("ETag", "\"one\"");
    response.set_content(picture, "image/jpeg");
  });
  const int port = server.bind_to_any_port("127.0.0.1");
  std::printf("%d\n", port);
  std::fflush(stdout);
  return server.listen_after_bind() ? 0 : 1;
}
