// A recording made worse as a whole, as cameras and links make it.
#pragma once

#include <span>

#include "sequence/recorded_sequence.h"
#include "support/own_folder.h"
#include "support/random.h"

namespace eifmap::test {

struct Degradation {
  const char* name;
  const char* title;  // for people
  bool random;        // whether another seed gives other images
  // Writes it all. Throws std::runtime_error on images that cannot be read or written.
  void (*write)(const RecordedSequence& sequence, Random& random, OwnFolder& folder);
};

// The first one is the recording itself.
std::span<const Degradation> all_degradations();

}  // namespace eifmap::test
