// Answers GET /metrics over HTTP, in a thread of its own.
#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <thread>

#include "program/listen_at.h"

struct lws;
struct lws_context;

namespace eifmap {

class MetricsServer {
 public:
  using MakeText = std::function<std::string()>;

  struct Opened;
  // Listens from now on; on loopback to this machine's names and numbers alone. `make_text` is
  // called for each answer, in the server's thread; what it throws is answered with 500.
  static Opened open(const ListenAt& at, MakeText make_text);

  ~MetricsServer();
  MetricsServer(const MetricsServer&) = delete;
  MetricsServer& operator=(const MetricsServer&) = delete;

  int port() const { return port_; }
  std::string url() const;

  static constexpr int kMaxConnections = 16;

 private:
  friend struct MetricsCallbacks;  // what libwebsockets calls

  MetricsServer(const ListenAt& at, MakeText make_text)
      : at_(at), make_text_(std::move(make_text)) {}
  std::string listen();
  void run();
  int begin_answer(lws* connection);
  int finish_answer(lws* connection);

  ListenAt at_;
  const MakeText make_text_;
  int port_ = 0;
  lws_context* context_ = nullptr;
  std::map<lws*, std::string> answers_;  // begun, each with room for libwebsockets before its text
  std::atomic<bool> stopping_ = false;
  std::thread thread_;
};

struct MetricsServer::Opened {
  std::unique_ptr<MetricsServer> server;
  std::string problem;  // "" when there is a server
};

}  // namespace eifmap
