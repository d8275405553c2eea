// Strange images put in among a recording's good ones.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "sequence/recorded_sequence.h"
#include "support/own_folder.h"
#include "support/random.h"

namespace eifmap::test {

enum class Corruption { kBlack, kNoise, kWrongSize, kShifted, kHalfCovered };

struct CorruptionName {
  Corruption kind;
  const char* name;
};
std::span<const CorruptionName> all_corruptions();

struct Corrupted {
  std::int64_t time_us = 0;
  Corruption kind = Corruption::kBlack;
};

// The first `frames` images as they are and `count` others at random places between them, each of
// one of the kinds, from the good image before it. Returns the others, by time. Throws
// std::runtime_error on images that cannot be read or written.
std::vector<Corrupted> write_corrupted(const RecordedSequence& sequence, int frames, int count,
                                       std::span<const Corruption> kinds, Random& random,
                                       OwnFolder& folder);

}  // namespace eifmap::test
