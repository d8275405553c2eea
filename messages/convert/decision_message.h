// What a live run decided by timing: decision_t <-> Decision.
#pragma once

#include <eifmap/decision_t.hpp>

#include "convert/pose_message.h"
#include "decision.h"
#include "wire/bytes.h"

namespace eifmap {

struct PublishedDecision {
  Origin origin;
  Decision decision;
};

decision_t to_message(const PublishedDecision& decision);

// Refuses with kMalformedMessage: sizes, name, time, a job below -1, a measurement without a
// number.
Decoded<PublishedDecision> decode_decision(Bytes bytes);

}  // namespace eifmap
