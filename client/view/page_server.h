// Serves the page over HTTP, and what it shows over a WebSocket: a snapshot first, then increments
// as text, and pictures (JPEG) as binary messages. Nothing is taken from the pages.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "client/view/page_queue.h"
#include "client/view/view_feed.h"
#include "program/listen_at.h"

struct lws;
struct lws_context;

namespace eifmap {

class PageServer {
 public:
  struct Opened;
  // Listens from now on. `view` must outlive the server.
  static Opened open(const ListenAt& at, View& view);

  ~PageServer();
  PageServer(const PageServer&) = delete;
  PageServer& operator=(const PageServer&) = delete;

  int port() const { return port_; }
  std::string url() const;
  std::size_t pages() const { return pages_.size(); }

  // Hands out what is new and answers what was asked, as far as that goes without waiting. To be
  // called every few ms, from the thread that fills the view.
  void service();

  static constexpr auto kIncrementPeriod = std::chrono::milliseconds(50);
  static constexpr std::size_t kMaxPages = 32;

 private:
  friend struct LwsCallbacks;  // what libwebsockets calls

  PageServer(const ListenAt& at, View& view) : at_(at), view_(view) {}
  std::string listen();
  void hand_out(ViewModel::Clock::time_point now);
  SharedMessage snapshot();
  bool admits(lws* page) const;
  void add(lws* page);
  bool write_next(lws* page);

  ListenAt at_;
  View& view_;
  int port_ = 0;
  lws_context* context_ = nullptr;
  std::map<lws*, PageQueue> pages_;
  SharedMessage snapshot_;  // as of now, when a page has asked for it
  SharedMessage picture_;   // the last one
  std::int64_t picture_number_ = 0;
  ViewModel::Clock::time_point next_increment_{};
  std::vector<unsigned char> scratch_;
};

struct PageServer::Opened {
  std::unique_ptr<PageServer> server;
  std::string problem;  // "" when there is a server
};

}  // namespace eifmap
