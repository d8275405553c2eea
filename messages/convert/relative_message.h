// Two keyframes to each other on request: relative_request_t and relative_t.
#pragma once

#include <eifmap/relative_request_t.hpp>
#include <eifmap/relative_t.hpp>

#include "convert/pose_message.h"
#include "map_view.h"
#include "wire/bytes.h"

namespace eifmap {

struct RelativeRequest {
  std::int64_t time_us = 0;
  std::int64_t requester = 0, request_id = 0;
  std::string camera;
  std::int64_t map_id = 0, a = 0, b = 0;  // the map in use; keyframes of it
};

struct RelativeAnswer {
  std::int64_t time_us = 0;
  Origin origin;
  RelativeRequest request;  // but for its time
  std::int64_t map_epoch = 0, map_seq = 0;
  Reason reason = Reason::kNone;
  RelativeView view;  // where there is no reason against it
};

relative_request_t to_message(const RelativeRequest& request);
relative_t to_message(const RelativeAnswer& answer);

// Refuse with kMalformedMessage: sizes, name, time, a requester that is 0; of an answer without a
// reason also a pose that is none or a covariance that is not finite.
Decoded<RelativeRequest> decode_relative_request(Bytes bytes);
Decoded<RelativeAnswer> decode_relative(Bytes bytes);

}  // namespace eifmap
