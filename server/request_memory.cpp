#include "server/request_memory.h"

#include <algorithm>

namespace eifmap {

const std::vector<std::uint8_t>* RequestMemory::reply_to(const Request& request) const {
  const auto found = std::find_if(done_.begin(), done_.end(), [&request](const Done& done) {
    return done.request.sender == request.sender && done.request.request_id == request.request_id;
  });
  return found == done_.end() ? nullptr : &found->reply;
}

std::string RequestMemory::problem(const Request& request) const {
  if (request.ticket <= forgotten_) return "its ticket is of before what is still remembered";
  for (const Done& done : done_)
    if (done.request.sender == request.sender && done.request.request_id > request.request_id)
      return "request " + std::to_string(done.request.request_id) +
             " of the same sender was done before it";
  return "";
}

void RequestMemory::keep(const Request& request, std::vector<std::uint8_t> reply) {
  bytes_ += reply.size();
  done_.push_back({request, std::move(reply)});
  while (done_.size() > kMostRequests || (bytes_ > kMostBytes && done_.size() > 1)) {
    forgotten_ = std::max(forgotten_, done_.front().request.ticket);
    bytes_ -= done_.front().reply.size();
    done_.pop_front();
  }
}

}  // namespace eifmap
