// A page by hand: a TCP connection that speaks HTTP and reads WebSocket frames, as fast or slowly
// as the test likes.
#pragma once

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <thread>

#include "client/view/page_server.h"

namespace eifmap::test {

class RawPage {
 public:
  explicit RawPage(PageServer& server) : server_(server) {
    socket_ = socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK, 0);
    sockaddr_in where{};
    where.sin_family = AF_INET;
    where.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    where.sin_port = htons(static_cast<std::uint16_t>(server.port()));
    connect(socket_, reinterpret_cast<const sockaddr*>(&where), sizeof(where));
  }
  ~RawPage() { close(socket_); }
  RawPage(const RawPage&) = delete;
  RawPage& operator=(const RawPage&) = delete;

  // Of an HTTP request, headers and body as they came.
  std::string request(const std::string& what, const std::string& more_headers = "") {
    send_text(what + " HTTP/1.1\r\nHost: " + host() + "\r\n" + more_headers + "\r\n");
    wait([this] { return answer_is_whole(); });
    return received_;
  }

  // True when the server takes it for a page.
  bool upgrade(const std::string& origin) {
    request("GET /",
            "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
            "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
            "Sec-WebSocket-Protocol: eifmap-view\r\nOrigin: " +
                origin + "\r\n");
    const std::size_t end = received_.find("\r\n\r\n");
    const bool taken = received_.starts_with("HTTP/1.1 101") && end != std::string::npos;
    if (taken) received_.erase(0, end + 4);
    return taken;
  }
  bool upgrade() { return upgrade("http://" + host()); }

  struct Frame {
    bool binary = false;
    std::string bytes;
  };
  // The next message; nothing when none comes.
  std::optional<Frame> next() {
    std::optional<Frame> frame;
    wait([&] { return (frame = cut_frame()).has_value(); });
    return frame;
  }

  // Lets the server work until `done`, or for 10 s.
  template <class Done>
  bool wait(Done done) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
    while (!done()) {
      if (std::chrono::steady_clock::now() > end) return false;
      server_.service();
      if (!read_some()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return true;
  }

  std::string host() const { return "127.0.0.1:" + std::to_string(server_.port()); }
  bool closed() const { return closed_; }

 private:
  void send_text(const std::string& text) {
    wait([&] {
      return ::send(socket_, text.data(), text.size(), MSG_NOSIGNAL) ==
             static_cast<ssize_t>(text.size());
    });
  }
  bool read_some() {
    char buffer[1 << 16];
    const ssize_t size = recv(socket_, buffer, sizeof(buffer), 0);
    if (size == 0) closed_ = true;
    if (size <= 0) return false;
    received_.append(buffer, static_cast<std::size_t>(size));
    return true;
  }
  bool answer_is_whole() const {
    const std::size_t end = received_.find("\r\n\r\n");
    if (closed_) return true;
    if (end == std::string::npos) return false;
    const std::size_t at = received_.find("content-length: ");
    if (at == std::string::npos || at > end) return true;
    return received_.size() >= end + 4 + std::stoul(received_.substr(at + 16));
  }
  // A server's frames are not masked; longer messages may come in several.
  std::optional<Frame> cut_frame() {
    while (received_.size() >= 2) {
      const auto byte = [this](std::size_t i) { return static_cast<std::uint8_t>(received_[i]); };
      std::size_t header = 2, size = byte(1) & 0x7f;
      const std::size_t extra = size == 127 ? 8 : size == 126 ? 2 : 0;
      if (received_.size() < header + extra) return {};
      if (extra > 0) size = 0;
      for (std::size_t i = 0; i < extra; ++i) size = size << 8 | byte(header + i);
      header += extra;
      if (received_.size() < header + size) return {};
      const int opcode = byte(0) & 0x0f;
      const bool last = byte(0) & 0x80;
      if (opcode != 0) open_ = {opcode == 2, ""};
      open_.bytes.append(received_, header, size);
      received_.erase(0, header + size);
      if (last) return open_;
    }
    return {};
  }

  PageServer& server_;
  int socket_;
  bool closed_ = false;
  std::string received_;
  Frame open_;
};

}  // namespace eifmap::test
