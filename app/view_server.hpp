// SPDX-License-Identifier: Apache-2.0
#pragma once
// The web server of `orthodrive view`: cpp-httplib, with bounds on what one who connects can take.

#include <httplib.h>

#include <atomic>
#include <memory>

#include "view_files.hpp"

namespace orthodrive::app {

/// Answers GET and HEAD for files, to those who call it by a name of this machine: a page of elsewhere whose name was
/// made to lead here (DNS rebinding) sends its own name in `Host`.
class ViewServer : public httplib::Server {
 public:
  explicit ViewServer(ViewFiles files);

  /// To be called between binding and listening; `port`: as bound, for it is part of `Host`.
  void expect_calls(int port);

  static constexpr int threads = 32;               ///< connections that are answered at a time
  static constexpr int most_waiting = 64;          ///< further connections; what comes then is closed at once
  static constexpr std::size_t most_head = 65536;  ///< bytes of a request line and all headers
  static constexpr int head_s = 5;                 ///< time for them
  static constexpr int stalled_s = 10;             ///< time for the next piece of an answer to be taken
  static constexpr int answer_s = 120;             ///< time for all of it

 private:
  bool process_and_close_socket(socket_t socket) override;
  void answer(const httplib::Request& request, httplib::Response& response) const;

  ViewFiles files_;
  int port_ = 0;
};

}  // namespace orthodrive::app
