// `orthodrive view` as a web server: what it gives out, what it keeps to itself, how it starts and ends.

#include <arpa/inet.h>
#include <httplib.h>
#include <signal.h>

#include <chrono>
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
    for (int i = 0; i < 200 && address().find('\n') == std::string::npos; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  ~Server() {
    if (child_ > 0) end(SIGKILL);
  }
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  [[nodiscard]] std::string address() const { return bytes_of(out_); }
  [[nodiscard]] int port() const { return std::atoi(address().substr(address().rfind(':') + 1).c_str()); }
  [[nodiscard]] httplib::Result get(const std::string& path) const {
    httplib::Client client("127.0.0.1", port());
    client.set_url_encode(false);  // paths go out as they are written
    return client.Get(path);
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

TEST(View, gives_out_nothing_else) {
  const TinySite tiny;
  const Server server(tiny);
  for (const char* path : {"/site/../secret.txt", "/site/%2e%2e/secret.txt", "/site/..%2fsecret.txt", "/../secret.txt",
                           "/site//../../secret.txt", "/site/scene/../../secret.txt", "/secret.txt",
                           "/site/nothing.json", "/sitescene/tileset.json"}) {
    SCOPED_TRACE(path);
    const auto response = server.get(path);
    ASSERT_TRUE(response);
    EXPECT_EQ(response->status, 404);
    EXPECT_THAT(response->body, testing::Not(testing::HasSubstr("secret")));
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
