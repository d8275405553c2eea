#include "client/view/page_server.h"

#include <libwebsockets.h>

#include <algorithm>
#include <array>
#include <optional>

#include "client/view/page_files.h"
#include "program/listen_http.h"

namespace eifmap {
namespace {

constexpr std::size_t kChunk = 64 * 1024;  // of a file or a message, at a time
constexpr int kRounds = 4;                 // of writing to every page, in a call of service()

// What libwebsockets keeps for each HTTP request, zeroed at its start.
struct Request {
  const PageFile* file;
  std::size_t sent;
};

// Writes by way of `scratch`: libwebsockets wants room before the bytes.
int write(lws* connection, std::vector<unsigned char>& scratch, std::string_view bytes,
          lws_write_protocol as) {
  scratch.resize(LWS_PRE + bytes.size());
  std::copy(bytes.begin(), bytes.end(), scratch.begin() + LWS_PRE);
  return lws_write(connection, scratch.data() + LWS_PRE, bytes.size(), as);
}

// "" where there is none; nothing where it is longer than any of an honest browser.
std::optional<std::string> header(lws* connection, lws_token_indexes which) {
  std::array<char, 256> text{};
  const int length = lws_hdr_copy(connection, text.data(), static_cast<int>(text.size()), which);
  if (length < 0) return {};
  return std::string(text.data(), static_cast<std::size_t>(length));
}

// Sends the headers of the file that is asked for. The result is libwebsockets': 0 goes on.
int begin_answer(lws* connection, Request& request) {
  char* uri = nullptr;
  int length = 0;
  const int method = lws_http_get_uri_and_method(connection, &uri, &length);
  const std::string_view path(uri ? uri : "", static_cast<std::size_t>(std::max(length, 0)));
  const auto files = page_files();
  const auto file =
      std::find_if(files.begin(), files.end(), [&](const PageFile& f) { return f.path == path; });
  if (method != LWSHUMETH_GET || file == files.end()) {
    lws_return_http_status(
        connection,
        method == LWSHUMETH_GET ? HTTP_STATUS_NOT_FOUND : HTTP_STATUS_METHOD_NOT_ALLOWED, nullptr);
    return lws_http_transaction_completed(connection);
  }
  std::array<unsigned char, LWS_PRE + 2048> buffer;
  unsigned char* const begin = buffer.data() + LWS_PRE;
  unsigned char* const end = buffer.data() + buffer.size() - 1;
  unsigned char* at = begin;
  constexpr std::string_view kNoStore = "no-store";  // another version may follow at this port
  if (lws_add_http_common_headers(connection, HTTP_STATUS_OK, std::string(file->type).c_str(),
                                  file->body.size(), &at, end) != 0 ||
      lws_add_http_header_by_token(connection, WSI_TOKEN_HTTP_CACHE_CONTROL,
                                   reinterpret_cast<const unsigned char*>(kNoStore.data()),
                                   kNoStore.size(), &at, end) != 0 ||
      lws_finalize_write_http_header(connection, begin, &at, end) != 0)
    return 1;
  request = {&*file, 0};
  lws_callback_on_writable(connection);
  return 0;
}

int continue_answer(lws* connection, Request& request, std::vector<unsigned char>& scratch) {
  if (!request.file) return 0;
  const std::string_view left = request.file->body.substr(request.sent);
  const std::string_view chunk = left.substr(0, kChunk);
  const bool last = chunk.size() == left.size();
  const int written =
      write(connection, scratch, chunk, last ? LWS_WRITE_HTTP_FINAL : LWS_WRITE_HTTP);
  if (written < static_cast<int>(chunk.size())) return 1;
  request.sent += chunk.size();
  if (last) return lws_http_transaction_completed(connection);
  lws_callback_on_writable(connection);
  return 0;
}

}  // namespace

// libwebsockets is C: nothing is thrown through it; what memory does not reach for is closed.
struct LwsCallbacks {
  static PageServer& server_of(lws* connection) {
    return *static_cast<PageServer*>(lws_context_user(lws_get_context(connection)));
  }

  static int http(lws* connection, lws_callback_reasons why, void* user, void* in,
                  std::size_t length) noexcept try {
    if (why == LWS_CALLBACK_HTTP) return begin_answer(connection, *static_cast<Request*>(user));
    if (why == LWS_CALLBACK_HTTP_WRITEABLE)
      return continue_answer(connection, *static_cast<Request*>(user),
                             server_of(connection).scratch_);
    return lws_callback_http_dummy(connection, why, user, in, length);
  } catch (...) {
    return 1;
  }

  static int web_socket(lws* connection, lws_callback_reasons why, void*, void*,
                        std::size_t) noexcept try {
    switch (why) {
      case LWS_CALLBACK_FILTER_PROTOCOL_CONNECTION:
        return server_of(connection).admits(connection) ? 0 : 1;
      case LWS_CALLBACK_ESTABLISHED:
        server_of(connection).add(connection);
        return 0;
      case LWS_CALLBACK_SERVER_WRITEABLE:
        return server_of(connection).write_next(connection) ? 0 : 1;
      case LWS_CALLBACK_CLOSED:
        server_of(connection).pages_.erase(connection);
        return 0;
      default:
        return 0;
    }
  } catch (...) {
    return 1;
  }
};

namespace {

constexpr std::size_t kMaxFromPage = 256;  // bytes; nothing is expected

const lws_protocols kProtocols[] = {
    {"http", LwsCallbacks::http, sizeof(Request), 0, 0, nullptr, kChunk},
    {"eifmap-view", LwsCallbacks::web_socket, 0, kMaxFromPage, 0, nullptr, kChunk},
    {nullptr, nullptr, 0, 0, 0, nullptr, 0}};

}  // namespace

PageServer::Opened PageServer::open(const ListenAt& at, View& view) {
  Opened opened;
  opened.problem = listen_problem(at);
  if (!opened.problem.empty()) return opened;
  std::unique_ptr<PageServer> server(new PageServer(at, view));
  opened.problem = server->listen();
  if (opened.problem.empty()) opened.server = std::move(server);
  return opened;
}

std::string PageServer::listen() {
  lws_context_creation_info info{};
  info.protocols = kProtocols;
  info.user = this;
  return listen_http(at_, info, context_, port_);
}

PageServer::~PageServer() {
  if (context_) lws_context_destroy(context_);
}

std::string PageServer::url() const {
  const std::string host = at_.address == "0.0.0.0" ? "127.0.0.1" : at_.address;
  return "http://" + host + ":" + std::to_string(port_) + "/";
}

void PageServer::service() {
  const auto now = ViewModel::Clock::now();
  if (now >= next_increment_) {
    hand_out(now);
    next_increment_ = now + kIncrementPeriod;
  }
  for (int i = 0; i < kRounds; ++i) lws_service(context_, -1);  // < 0: does not wait
}

void PageServer::hand_out(ViewModel::Clock::time_point now) {
  SharedMessage increment, picture;
  if (std::string text = view_.model.take_increment(now); !text.empty()) {
    increment = std::make_shared<PageMessage>(PageMessage{std::move(text), false});
    snapshot_.reset();
  }
  if (view_.picture.number() != picture_number_) {
    picture_number_ = view_.picture.number();
    picture = std::make_shared<PageMessage>(PageMessage{view_.picture.jpeg(), true});
    if (picture->bytes.empty()) picture.reset();  // the pages know by themselves
    picture_ = picture;
  }
  for (auto& [page, queue] : pages_) {
    if (increment) queue.push(increment);
    if (picture) queue.push_picture(picture);
    if (!queue.empty()) lws_callback_on_writable(page);
  }
}

SharedMessage PageServer::snapshot() {
  if (!snapshot_)
    snapshot_ = std::make_shared<PageMessage>(PageMessage{view_.model.snapshot(), false});
  return snapshot_;
}

bool PageServer::admits(lws* page) const {
  const auto host = header(page, WSI_TOKEN_HOST), origin = header(page, WSI_TOKEN_ORIGIN);
  return pages_.size() < kMaxPages && host && origin && may_look(*host, *origin, at_.loopback());
}

void PageServer::add(lws* page) {
  PageQueue& queue = pages_.try_emplace(page).first->second;
  if (picture_) queue.push_picture(picture_);
  lws_callback_on_writable(page);
}

// False when the page is gone. What the socket does not take at once libwebsockets keeps, one
// message at the most: it asks for the next when that has left.
bool PageServer::write_next(lws* page) {
  PageQueue& queue = pages_.at(page);
  const SharedMessage message = queue.pop([this] { return snapshot(); });
  if (!message) return true;
  const int written =
      write(page, scratch_, message->bytes, message->binary ? LWS_WRITE_BINARY : LWS_WRITE_TEXT);
  if (written < static_cast<int>(message->bytes.size())) return false;
  if (!queue.empty()) lws_callback_on_writable(page);
  return true;
}

}  // namespace eifmap
