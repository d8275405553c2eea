// CPU time of the filter: an update per keyframe along a lap, and whole iterations.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <ctime>
#include <vector>

#include "support/long_way.h"

namespace eifmap::test {
namespace {

double cpu_seconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double median(std::vector<double> values, std::size_t from, std::size_t to) {
  std::vector<double> some(values.begin() + static_cast<long>(from),
                           values.begin() + static_cast<long>(to));
  std::nth_element(some.begin(), some.begin() + static_cast<long>(some.size() / 2), some.end());
  return some[some.size() / 2];
}

const LongWay& lap() {
  static const LongWay world = make_long_way(round_course(1010, 1000), {});
  return world;
}

// One lap, and ten keyframes beyond its end.
void one_lap(benchmark::State& state) {
  for (auto _ : state) {
    LongWayFeed feed(lap(), FilterOptions{});
    std::vector<double> ms;
    while (!feed.done()) {
      feed.add_next();
      const double before = cpu_seconds();
      feed.filter().update();
      ms.push_back(1e3 * (cpu_seconds() - before));
    }
    state.counters["ms_100_200"] = median(ms, 100, 200);
    state.counters["ms_500_600"] = median(ms, 500, 600);
    state.counters["ms_900_990"] = median(ms, 900, 990);
    state.counters["ms_most_closing"] = *std::max_element(ms.begin() + 990, ms.end());
    state.counters["ms_sum_closing"] = 0;
    for (std::size_t k = 990; k < ms.size(); ++k) state.counters["ms_sum_closing"] += ms[k];
    state.counters["observations"] = static_cast<double>(feed.filter().num_measurements());
    state.counters["landmarks"] = static_cast<double>(feed.filter().num_landmarks());
  }
}
BENCHMARK(one_lap)->Unit(benchmark::kSecond)->Iterations(1);

}  // namespace
}  // namespace eifmap::test

BENCHMARK_MAIN();
