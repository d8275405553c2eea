#include "server/metrics_server.h"

#include <libwebsockets.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "program/listen_http.h"

namespace eifmap {
namespace {

constexpr std::string_view kType = "text/plain; version=0.0.4; charset=utf-8";

int refuse(lws* connection, unsigned status) {
  lws_return_http_status(connection, status, nullptr);
  return lws_http_transaction_completed(connection);
}

// "" where there is none, or one longer than any of an honest client.
std::string header(lws* connection, lws_token_indexes which) {
  std::array<char, 256> text{};
  const int length = lws_hdr_copy(connection, text.data(), static_cast<int>(text.size()), which);
  return {text.data(), static_cast<std::size_t>(std::max(length, 0))};
}

// 0 or the HTTP status of what is wrong with the request.
unsigned problem_of(lws* connection, bool loopback) {
  if (!may_look(header(connection, WSI_TOKEN_HOST), header(connection, WSI_TOKEN_ORIGIN), loopback))
    return HTTP_STATUS_FORBIDDEN;
  char* uri = nullptr;
  int length = 0;
  const int method = lws_http_get_uri_and_method(connection, &uri, &length);
  if (method != LWSHUMETH_GET) return HTTP_STATUS_METHOD_NOT_ALLOWED;
  const std::string_view path(uri ? uri : "", static_cast<std::size_t>(std::max(length, 0)));
  return path == "/metrics" ? 0 : HTTP_STATUS_NOT_FOUND;
}

}  // namespace

// libwebsockets is C: nothing is thrown through it; what memory does not reach for is closed.
struct MetricsCallbacks {
  static int http(lws* connection, lws_callback_reasons why, void* user, void* in,
                  std::size_t length) noexcept try {
    const auto server = static_cast<MetricsServer*>(lws_context_user(lws_get_context(connection)));
    if (why == LWS_CALLBACK_HTTP) return server->begin_answer(connection);
    if (why == LWS_CALLBACK_HTTP_WRITEABLE) return server->finish_answer(connection);
    if (why == LWS_CALLBACK_CLOSED_HTTP) server->answers_.erase(connection);
    return lws_callback_http_dummy(connection, why, user, in, length);
  } catch (...) {
    return 1;
  }
};

namespace {

const lws_protocols kProtocols[] = {{"http", MetricsCallbacks::http, 0, 0, 0, nullptr, 0},
                                    {nullptr, nullptr, 0, 0, 0, nullptr, 0}};

}  // namespace

MetricsServer::Opened MetricsServer::open(const ListenAt& at, MakeText make_text) {
  Opened opened;
  opened.problem = listen_problem(at);
  if (!opened.problem.empty()) return opened;
  std::unique_ptr<MetricsServer> server(new MetricsServer(at, std::move(make_text)));
  opened.problem = server->listen();
  if (!opened.problem.empty()) return opened;
  server->thread_ = std::thread(&MetricsServer::run, server.get());
  opened.server = std::move(server);
  return opened;
}

std::string MetricsServer::listen() {
  lws_context_creation_info info{};
  info.protocols = kProtocols;
  info.max_http_header_pool = kMaxConnections;
  info.user = this;
  return listen_http(at_, info, context_, port_);
}

MetricsServer::~MetricsServer() {
  stopping_ = true;
  if (context_) lws_cancel_service(context_);
  if (thread_.joinable()) thread_.join();
  if (context_) lws_context_destroy(context_);
}

std::string MetricsServer::url() const {
  return "http://" + at_.address + ":" + std::to_string(port_) + "/metrics";
}

void MetricsServer::run() {
  while (!stopping_ && lws_service(context_, 0) >= 0) {
  }
}

int MetricsServer::begin_answer(lws* connection) {
  if (const unsigned status = problem_of(connection, at_.loopback()); status != 0)
    return refuse(connection, status);
  std::string text(LWS_PRE, '\0');
  try {
    text += make_text_();
  } catch (const std::exception&) {
    return refuse(connection, HTTP_STATUS_INTERNAL_SERVER_ERROR);
  }
  std::array<unsigned char, LWS_PRE + 1024> buffer;
  unsigned char* const begin = buffer.data() + LWS_PRE;
  unsigned char* const end = buffer.data() + buffer.size() - 1;
  unsigned char* at = begin;
  if (lws_add_http_common_headers(connection, HTTP_STATUS_OK, kType.data(), text.size() - LWS_PRE,
                                  &at, end) != 0 ||
      lws_finalize_write_http_header(connection, begin, &at, end) != 0)
    return 1;
  answers_[connection] = std::move(text);
  lws_callback_on_writable(connection);
  return 0;
}

// At once: what the socket does not take libwebsockets keeps, and sends as it can.
int MetricsServer::finish_answer(lws* connection) {
  const auto found = answers_.find(connection);
  if (found == answers_.end()) return 0;
  std::string text = std::move(found->second);
  answers_.erase(found);
  const std::size_t length = text.size() - LWS_PRE;
  const int written = lws_write(connection, reinterpret_cast<unsigned char*>(text.data()) + LWS_PRE,
                                length, LWS_WRITE_HTTP_FINAL);
  if (written < static_cast<int>(length)) return 1;
  return lws_http_transaction_completed(connection);
}

}  // namespace eifmap
