#include <sys/mman.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <stdexcept>

#include "fuzz/target.h"

namespace eifmap::fuzz {

std::vector<Target> all_targets() {
  std::vector<Target> all;
  for (const auto& some : {message_targets(), file_targets(), server_targets(), storage_targets()})
    all.insert(all.end(), some.begin(), some.end());
  return all;
}

void require(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "does not hold: %s\n", what);
  std::abort();
}

MemoryFile::MemoryFile(Bytes bytes) : descriptor_(memfd_create("fuzz", 0)) {
  if (descriptor_ < 0 ||
      write(descriptor_, bytes.data(), bytes.size()) != static_cast<ssize_t>(bytes.size()))
    throw std::runtime_error("no file in memory");
}

MemoryFile::~MemoryFile() {
  close(descriptor_);
}

}  // namespace eifmap::fuzz
