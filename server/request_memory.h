// Requests that were done, with their replies: so that none is done twice. Knows no clock.
#pragma once

#include <cstdint>
#include <deque>
#include <string>
#include <vector>

namespace eifmap {

class RequestMemory {
 public:
  // Kept at most. What was forgotten is not done again either: a new request names a ticket that is
  // greater than those of all that were forgotten.
  static constexpr std::size_t kMostRequests = 1024, kMostBytes = 1u << 20;

  struct Request {
    std::int64_t sender = 0, request_id = 0;
    std::int64_t ticket = 0;  // grows with time
  };

  // The reply to the same request; null where it is not remembered.
  const std::vector<std::uint8_t>* reply_to(const Request& request) const;

  // Of one that is not remembered: "" it is new, or why it may have been done before.
  std::string problem(const Request& request) const;

  void keep(const Request& request, std::vector<std::uint8_t> reply);

  std::size_t size() const { return done_.size(); }

 private:
  struct Done {
    Request request;
    std::vector<std::uint8_t> reply;
  };
  std::deque<Done> done_;  // the last ones, by when they were done
  std::size_t bytes_ = 0;
  std::int64_t forgotten_ = 0;  // the greatest ticket of those that were forgotten
};

}  // namespace eifmap
