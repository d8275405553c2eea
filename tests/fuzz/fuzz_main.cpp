// libFuzzer's side: EIFMAP_FUZZ_TARGET says what is fuzzed. With EIFMAP_FUZZ_SEEDS, a folder, the
// seeds of all are written there instead, each target's into a folder of its own.
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "fuzz/target.h"

using eifmap::fuzz::Target;

namespace {

void write_seeds(const std::filesystem::path& folder) {
  for (const Target& target : eifmap::fuzz::all_targets()) {
    std::filesystem::create_directories(folder / target.name);
    int number = 0;
    for (const eifmap::fuzz::Wire& seed : target.seeds())
      std::ofstream(folder / target.name / std::to_string(number++), std::ios::binary)
          .write(reinterpret_cast<const char*>(seed.data()), std::ssize(seed));
  }
}

const Target& chosen() {
  static const Target target = [] {
    const char* name = std::getenv("EIFMAP_FUZZ_TARGET");
    for (Target& known : eifmap::fuzz::all_targets())
      if (name && known.name == name) return known;
    std::fprintf(stderr, "EIFMAP_FUZZ_TARGET must name what is fuzzed, one of:");
    for (const Target& known : eifmap::fuzz::all_targets())
      std::fprintf(stderr, " %s", known.name.c_str());
    std::fprintf(stderr, "\n");
    std::exit(2);
  }();
  return target;
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  if (const char* seeds = std::getenv("EIFMAP_FUZZ_SEEDS")) {
    write_seeds(seeds);
    std::exit(0);
  }
  chosen();
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  chosen().run({data, size});
  return 0;
}
