// What waits to go to one page. A page that takes it more slowly than it comes does not make this
// grow: what waits is dropped, and the page gets a snapshot when it takes something again.
#pragma once

#include <cstddef>
#include <deque>
#include <functional>
#include <memory>
#include <string>

namespace eifmap {

struct PageMessage {
  std::string bytes;
  bool binary = false;  // a picture; else JSON
};

// One copy for all pages.
using SharedMessage = std::shared_ptr<const PageMessage>;

class PageQueue {
 public:
  explicit PageQueue(std::size_t max_bytes = 4u << 20) : max_bytes_(max_bytes) {}

  void push(SharedMessage increment);
  void push_picture(SharedMessage picture);  // only the newest waits

  bool empty() const { return !wants_snapshot_ && increments_.empty() && !picture_; }
  // The first is a snapshot, as made now. Nothing when it is empty.
  SharedMessage pop(const std::function<SharedMessage()>& snapshot);

  std::size_t waiting_bytes() const { return bytes_; }  // increments

 private:
  std::size_t max_bytes_, bytes_ = 0;
  bool wants_snapshot_ = true;
  std::deque<SharedMessage> increments_;
  SharedMessage picture_;
};

}  // namespace eifmap
