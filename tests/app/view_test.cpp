// SPDX-License-Identifier: Apache-2.0
// `orthodrive view` as a web server: what it gives out, what it keeps to itself, how it starts and ends.

#include <arpa/inet.h>
#include <httplib.h>
#include <poll.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <memory>
#include <thread>

#include "app/expect_clean_failure.hpp"
#include "paths.hpp"

namespace orthodrive {
namespace {

/// A site and a viewer of a few bytes each, and a file outside of both.
struct TinySite {
  Scratch scratch;
  std::filesystem::path site = scratch / "site";
  TinySite() {
    for (const char* folder : {"site/scene", "site/drive", "viewer/assets"})
      std::filesystem::create_directories(scratch / folder);
    write_bytes(scratch / "viewer/index.html", "<p>viewer</p>");
    write_bytes(scratch / "viewer/assets/index.js", "let a;");
    write_bytes(scratch / "site/scene/tileset.json", "{}");
    write_bytes(scratch / "site/scene/tile_0_0.glb", std::string("glTF\0\1", 6));
    write_bytes(scratch / "site/drive/lap.csv", "t_s\n");
    write_bytes(scratch / "site/findings.geojson", "{}");
    write_bytes(scratch / "secret.txt", "secret");
    setenv("ORTHODRIVE_VIEWER_DIR", (scratch / "viewer").c_str(), 1);
  }
  ~TinySite() { unsetenv("ORTHODRIVE_VIEWER_DIR"); }
};

/// A running `orthodrive view`; ends it when the test ends early.
class Server {
 public:
  explicit Server(const TinySite& tiny)
      : out_(tiny.scratch / "server_out"),
        child_(start_program({paths::tool, "view", tiny.site, "--port", "0", "--no-open"}, out_,
                             tiny.scratch / "server_err")) {
    for (int i = 0; i < 6000 && address().find('\n') == std::string::npos; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  ~Server() {
    if (child_ > 0) end(SIGKILL);
  }
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  [[nodiscard]] std::string address() const { return bytes_of(out_); }
  [[nodiscard]] int port() const { return std::stoi(address().substr(address().rfind(':') + 1)); }
  [[nodiscard]] httplib::Result get(const std::string& path) const {
    httplib::Client client("127.0.0.1", port());
    client.set_url_encode(false);  // paths go out as they are written
    return client.Get(path);
  }
  [[nodiscard]] std::ptrdiff_t open_files() const {
    const std::filesystem::directory_iterator files("/proc/" + std::to_string(child_) + "/fd");
    return std::distance(files, std::filesystem::directory_iterator());
  }
  int end(int signal_number) {
    kill(child_, signal_number);
    return wait_for(std::exchange(child_, 0));
  }

 private:
  std::filesystem::path out_;
  pid_t child_;
};

TEST(View, serves_viewer_and_site_with_their_types) {
  const TinySite tiny;
  const Server server(tiny);
  ASSERT_THAT(server.address(), testing::MatchesRegex("http://127\\.0\\.0\\.1:[0-9]+/\n"));
  const std::vector<std::array<std::string, 3>> expected{
      {"/", "text/html", "<p>viewer</p>"},
      {"/assets/index.js", "text/javascript", "let a;"},
      {"/site/scene/tileset.json", "application/json", "{}"},
      {"/site/scene/tile_0_0.glb", "model/gltf-binary", std::string("glTF\0\1", 6)},
      {"/site/drive/lap.csv", "text/csv", "t_s\n"},
      {"/site/findings.geojson", "application/geo+json", "{}"},
  };
  for (const auto& [path, type, body] : expected) {
    SCOPED_TRACE(path);
    const auto response = server.get(path);
    ASSERT_TRUE(response);
    EXPECT_EQ(response->status, 200);
    EXPECT_THAT(response->get_header_value("Content-Type"), testing::StartsWith(type));
    EXPECT_EQ(response->body, body);
    EXPECT_EQ(response->get_header_value("Cache-Control"), "no-cache");
  }
}

/// What a client sent by hand gets back: everything until the server closes, or until it stays silent for `patience_s`.
class RawClient {
 public:
  explicit RawClient(int port) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET, address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    connected_ = connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  }
  ~RawClient() { close(socket_); }
  RawClient(const RawClient&) = delete;
  RawClient& operator=(const RawClient&) = delete;

  [[nodiscard]] bool send(const std::string& bytes) const {
    return connected_ &&
           ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(bytes.size());
  }
  [[nodiscard]] std::string receive(int patience_s = 5) const {
    const timeval patience{patience_s, 0};
    setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    std::string all;
    std::array<char, 4096> bytes;
    for (ssize_t count = 0; (count = recv(socket_, bytes.data(), bytes.size(), 0)) > 0;)
      all.append(bytes.data(), static_cast<std::size_t>(count));
    return all;
  }
  /// The server has closed, or closes within so many seconds.
  [[nodiscard]] bool is_closed(int within_s) const {
    pollfd waiting{socket_, POLLIN, 0};
    char byte = 0;
    return !connected_ || (poll(&waiting, 1, 1000 * within_s) == 1 && recv(socket_, &byte, 1, 0) <= 0);
  }

 private:
  int socket_;
  bool connected_ = false;
};

std::string raw(const Server& server, const std::string& request) {
  const RawClient client(server.port());
  EXPECT_TRUE(client.send(request));
  return client.receive();
}

std::string get_as(const Server& server, const std::string& target, const std::string& further_lines = "") {
  return raw(server, "GET " + target + " HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(server.port()) + "\r\n" +
                         further_lines + "Connection: close\r\n\r\n");
}

TEST(View, gives_out_nothing_else) {
  const TinySite tiny;
  const Server server(tiny);
  for (const std::string path : {"/site/../secret.txt",
                                 "/site/%2e%2e/secret.txt",
                                 "/site/..%2fsecret.txt",
                                 "/../secret.txt",
                                 "/site//../../secret.txt",
                                 "/site/scene/../../secret.txt",
                                 "/secret.txt",
                                 "/site/nothing.json",
                                 "/sitescene/tileset.json",
                                 "/site/scene/%2e%2e/run.json",
                                 "/site/./run.json",
                                 "/site//run.json",
                                 "/site/%2e%2e%5csecret.txt",
                                 "/site/..\\secret.txt",
                                 "/site/run.json%00",
                                 "/site/run.json%00.glb",
                                 "/site/%252e%252e/secret.txt",
                                 "/site/%u002e%u002e/secret.txt",
                                 "/site/scene",
                                 "/site/scene/",
                                 "/site/",
                                 "/assets/",
                                 "/assets",
                                 "site/run.json",
                                 "//site/run.json",
                                 "/%2fetc/passwd",
                                 "//etc/passwd",
                                 "http://127.0.0.1/site/run.json",
                                 "file:///etc/passwd",
                                 "*"}) {
    SCOPED_TRACE(path);
    const std::string answer = get_as(server, path);
    EXPECT_THAT(answer, testing::MatchesRegex("HTTP/1.1 40[04] (.|\n)*"));
    EXPECT_THAT(answer, testing::Not(testing::HasSubstr("secret")));
    EXPECT_THAT(answer, testing::Not(testing::HasSubstr("root:")));
  }
  EXPECT_THAT(get_as(server, "/site/" + std::string(2000, 'a') + ".json"), testing::StartsWith("HTTP/1.1 404"));
  EXPECT_THAT(get_as(server, "/" + std::string(20'000, 'a')), testing::StartsWith("HTTP/1.1 4"));
}

/// Of a site only what the viewer reads: no checkpoints, sources or further results, and nothing behind a dot.
TEST(View, keeps_to_itself_what_the_viewer_does_not_need) {
  const TinySite tiny;
  for (const char* folder : {"site/.orthodrive", "site/scene/.hidden", "viewer/.git"})
    std::filesystem::create_directories(tiny.scratch / folder);
  const std::vector<std::string> kept{"site.toml",    "roads.gpkg",  "report.html",
                                      "labels.tif",   "out.txt",     ".orthodrive/alignment.csv",
                                      ".hidden.json", "drive.csv",   ".orthodrive/drive.json",
                                      "scene/a.html", "scene/a.svg", "scene/.hidden/a.glb"};
  for (const std::string& name : kept) write_bytes(tiny.site / name, "time_s,lat,lon\n");
  write_bytes(tiny.site / ".orthodrive/lap.csv", "t_s,x_m,y_m\n");
  write_bytes(tiny.scratch / "viewer/.git/config", "secret");
  const Server server(tiny);
  for (const std::string& name : kept) EXPECT_EQ(server.get("/site/" + name)->status, 404) << name;
  EXPECT_EQ(server.get("/site/.orthodrive/lap.csv")->status, 404);
  EXPECT_EQ(server.get("/.git/config")->status, 404);
}

TEST(View, a_second_lap_may_lie_anywhere_in_the_site) {
  const TinySite tiny;
  std::filesystem::create_directories(tiny.site / "other car/wet");
  write_bytes(tiny.site / "other car/wet/1.csv", "t_s,s_m,x_m,y_m\r\n0,0,1,2\r\n");
  const Server server(tiny);
  EXPECT_EQ(server.get("/site/other%20car/wet/1.csv")->body, "t_s,s_m,x_m,y_m\r\n0,0,1,2\r\n");
}

TEST(View, follows_no_link_out) {
  const TinySite tiny;
  std::filesystem::create_directories(tiny.site / ".orthodrive");
  write_bytes(tiny.site / "site.toml", "secret");
  write_bytes(tiny.site / ".orthodrive/a.json", "secret");
  std::filesystem::create_directories(tiny.scratch / "site2");  // begins like the site
  write_bytes(tiny.scratch / "site2/a.json", "secret");
  std::filesystem::create_symlink(tiny.scratch / "secret.txt", tiny.site / "run.json");
  std::filesystem::create_symlink(tiny.site.parent_path(), tiny.site / "scene/out");
  std::filesystem::create_symlink("../../site2/a.json", tiny.site / "scene/near.json");
  std::filesystem::create_symlink("../site.toml", tiny.site / "scene/sources.json");
  std::filesystem::create_symlink("../.orthodrive/a.json", tiny.site / "scene/hidden.json");
  std::filesystem::create_symlink("loop.json", tiny.site / "scene/loop.json");
  std::filesystem::create_symlink("/dev/zero", tiny.site / "scene/zero.glb");
  std::filesystem::create_symlink(tiny.site / "scene/tile_0_0.glb", tiny.site / "scene/inside.glb");
  std::filesystem::create_symlink("../secret.txt", tiny.scratch / "viewer/secret.js");
  ASSERT_EQ(mkfifo((tiny.site / "roads.xodr").c_str(), 0600), 0);
  const Server server(tiny);
  for (const char* path : {"/site/run.json", "/site/scene/out/site2/a.json", "/site/scene/near.json",
                           "/site/roads.xodr", "/site/scene/sources.json", "/site/scene/hidden.json",
                           "/site/scene/loop.json", "/site/scene/zero.glb", "/secret.js"}) {
    SCOPED_TRACE(path);
    const auto response = server.get(path);
    ASSERT_TRUE(response);
    EXPECT_EQ(response->status, 404);
    EXPECT_THAT(response->body, testing::Not(testing::HasSubstr("secret")));
  }
  EXPECT_EQ(server.get("/site/scene/inside.glb")->status, 200);
}

/// A page of elsewhere whose name was made to lead here is no page of ours.
TEST(View, answers_to_its_own_names_only) {
  const TinySite tiny;
  const Server server(tiny);
  const std::string port = ":" + std::to_string(server.port());
  const auto status_of = [&](const std::string& lines) {
    return raw(server, "GET / HTTP/1.1\r\n" + lines + "Connection: close\r\n\r\n").substr(0, 12);
  };
  for (const std::string name : {"127.0.0.1", "localhost", "LocalHost", "[::1]"})
    EXPECT_EQ(status_of("Host: " + name + port + "\r\n"), "HTTP/1.1 200") << name;
  for (const std::string& host : {"evil.example" + port, std::string("127.0.0.1"), std::string("127.0.0.1:1"), port,
                                  "127.0.0.1.evil.example" + port, "localhost" + port + ".evil.example",
                                  "0.0.0.0" + port, "a@localhost" + port, "localhost:" + port, std::string()})
    EXPECT_EQ(status_of("Host: " + host + "\r\n"), "HTTP/1.1 403") << host;
  EXPECT_EQ(status_of(""), "HTTP/1.1 403");
  EXPECT_EQ(status_of("Host: localhost" + port + "\r\nHost: evil.example\r\n"), "HTTP/1.1 403");

  const std::string host = "Host: localhost" + port + "\r\n";
  EXPECT_EQ(status_of(host + "Origin: http://localhost" + port + "\r\n"), "HTTP/1.1 200");
  for (const std::string& origin :
       {std::string("http://evil.example"), std::string("null"), "https://localhost" + port})
    EXPECT_EQ(status_of(host + "Origin: " + origin + "\r\n"), "HTTP/1.1 403") << origin;
}

TEST(View, answers_no_method_that_changes_anything) {
  const TinySite tiny;
  const Server server(tiny);
  const std::string host = " HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(server.port()) + "\r\n";
  for (const std::string method : {"POST", "PUT", "DELETE", "PATCH", "OPTIONS", "TRACE", "CONNECT"})
    EXPECT_THAT(raw(server, method + " /site/run.json" + host + "Content-Length: 5\r\n\r\nhello"),
                testing::StartsWith("HTTP/1.1 405"))
        << method;
  EXPECT_THAT(raw(server, "MAKE /" + host + "\r\n"), testing::StartsWith("HTTP/1.1 400"));
  const std::string head = raw(server, "HEAD /" + host + "Connection: close\r\n\r\n");
  EXPECT_THAT(head, testing::StartsWith("HTTP/1.1 200"));
  EXPECT_THAT(head, testing::EndsWith("\r\n\r\n"));
  // A second request in the body of the first is not one.
  const std::string two = "GET /" + host + "Content-Length: 60\r\n\r\nGET /site/scene/tileset.json" + host + "\r\n";
  EXPECT_THAT(raw(server, two),
              testing::AllOf(testing::StartsWith("HTTP/1.1 405"), testing::Not(testing::HasSubstr("200 OK"))));
}

TEST(View, tells_the_browser_what_to_keep_out) {
  const TinySite tiny;
  const Server server(tiny);
  for (const char* path : {"/", "/site/scene/tileset.json", "/nothing"}) {
    const auto response = server.get(path);
    EXPECT_EQ(response->get_header_value("X-Content-Type-Options"), "nosniff") << path;
    EXPECT_EQ(response->get_header_value("Cross-Origin-Resource-Policy"), "same-origin") << path;
    EXPECT_FALSE(response->has_header("Access-Control-Allow-Origin")) << path;
  }
  EXPECT_THAT(server.get("/")->get_header_value("Content-Security-Policy"),
              testing::AllOf(testing::HasSubstr("default-src 'none'"), testing::HasSubstr("frame-ancestors 'none'"),
                             testing::Not(testing::HasSubstr("unsafe-inline"))));
  EXPECT_THAT(server.get("/site/findings.geojson")->get_header_value("Content-Security-Policy"),
              testing::HasSubstr("sandbox"));
}

TEST(View, gives_out_parts_of_files) {
  const TinySite tiny;
  write_bytes(tiny.site / "roads.xodr", "0123456789");
  write_bytes(tiny.site / "run.json", "");
  const Server server(tiny);
  const auto part = [&](const std::string& range) {
    return get_as(server, "/site/roads.xodr", "Range: bytes=" + range + "\r\n");
  };
  for (const auto& [range, body] : std::vector<std::pair<std::string, std::string>>{
           {"0-2", "012"}, {"7-", "789"}, {"-3", "789"}, {"8-99999999999999", "89"}, {"-99", "0123456789"}}) {
    EXPECT_THAT(part(range), testing::StartsWith("HTTP/1.1 206")) << range;
    EXPECT_THAT(part(range), testing::EndsWith("\r\n\r\n" + body)) << range;
  }
  EXPECT_THAT(part("2-4"), testing::HasSubstr("Content-Range: bytes 2-4/10"));
  for (const char* range : {"10-", "99-100", "4-2", "x", "99999999999999999999999-"})
    EXPECT_THAT(part(range), testing::StartsWith("HTTP/1.1 416")) << range;
  // Many parts would be gathered in memory: the whole file is given instead.
  std::string many = "0-";
  while (many.size() < 8000) many += ",0-";
  EXPECT_THAT(part(many), testing::AllOf(testing::StartsWith("HTTP/1.1 200"), testing::EndsWith("\r\n\r\n0123456789")));
  EXPECT_THAT(get_as(server, "/site/run.json", "Range: bytes=0-5\r\n"), testing::StartsWith("HTTP/1.1 200"));
}

/// Who opens connections and says little, or says too much, is let go; others are answered meanwhile.
TEST(View, bounds_what_a_client_can_take) {
  const TinySite tiny;
  const Server server(tiny);
  const std::string begun = "GET / HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(server.port()) + "\r\n";
  {
    std::string head = begun;
    while (head.size() < 100'000) head += "X: " + std::string(1000, 'a') + "\r\n";
    const RawClient client(server.port());
    (void)client.send(head + "\r\n");
    EXPECT_THAT(client.receive(), testing::Not(testing::HasSubstr("200 OK")));
  }
  {
    std::vector<std::unique_ptr<RawClient>> slow;
    for (int i = 0; i < 20; ++i)
      EXPECT_TRUE(slow.emplace_back(std::make_unique<RawClient>(server.port()))->send(begun));
    EXPECT_EQ(server.get("/")->status, 200);
    for (int second = 0; second < 9 && !slow.front()->is_closed(0); ++second) {
      (void)slow.front()->send("X: a\r\n");  // a line a second, for ever
      std::this_thread::sleep_for(std::chrono::seconds(1));
    }
    for (const auto& client : slow) EXPECT_THAT(client->receive(2), testing::Not(testing::HasSubstr("200 OK")));
  }
  std::vector<std::unique_ptr<RawClient>> many;
  for (int i = 0; i < 300; ++i) many.push_back(std::make_unique<RawClient>(server.port()));
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  EXPECT_LT(server.open_files(), 150);
  many.clear();
  const auto start = std::chrono::steady_clock::now();
  for (bool answered = false; !answered;) {
    const auto response = server.get("/");
    answered = response && response->status == 200;
    ASSERT_LT(std::chrono::steady_clock::now() - start, std::chrono::minutes(5));
  }
}

TEST(View, listens_on_the_loopback_address_only) {
  const TinySite tiny;
  const Server server(tiny);
  httplib::Client other("127.0.0.2", server.port());  // also this machine, but not the address it serves on
  EXPECT_FALSE(other.Get("/"));
}

TEST(View, ends_well_on_interrupt_and_terminate) {
  const TinySite tiny;
  for (const int signal_number : {SIGINT, SIGTERM}) {
    Server server(tiny);
    EXPECT_EQ(server.get("/")->status, 200);
    EXPECT_EQ(server.end(signal_number), 0);
  }
}

TEST(View, a_port_in_use_is_one_clear_line) {
  const TinySite tiny;
  const Server server(tiny);
  const std::string port = std::to_string(server.port());
  expect_clean_failure(tiny.site, "127.0.0.1:" + port, [&] {
    return run_tool({"view", tiny.site, "--no-open", "--port", port});
  });
}

TEST(View, a_folder_that_is_no_site_is_one_clear_line) {
  const TinySite tiny;
  expect_clean_failure(tiny.site, tiny.scratch / "viewer", [&] {
    return run_tool({"view", tiny.scratch / "viewer", "--no-open"});
  });
}

TEST(View, a_viewer_that_is_not_built_is_one_clear_line) {
  const TinySite tiny;
  std::filesystem::remove(tiny.scratch / "viewer/index.html");
  expect_clean_failure(tiny.site, tiny.scratch / "viewer", [&] { return run_tool({"view", tiny.site, "--no-open"}); });
}

}  // namespace
}  // namespace orthodrive
