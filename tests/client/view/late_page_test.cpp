#include <gtest/gtest.h>

#include <random>

#include "client/view/page_copy.h"
#include "client/view/view_messages.h"
#include "client/view/view_model.h"

namespace eifmap {
namespace {

using namespace test;
using namespace std::chrono_literals;

const ViewModel::Clock::time_point kStart{};

// Poses, losses, map updates in parts with corrections and removals, new maps, restarts: at random.
class RandomServer {
 public:
  explicit RandomServer(unsigned seed) : random_(seed) {}

  void step(ViewModel& model, ViewModel::Clock::time_point now) {
    const unsigned dice = random_() % 100;
    if (dice < 60) {
      model.take(pose(epoch_, map_id_, time_++, dice < 5 ? TrackingState::kLost : kTracking), now);
    } else if (dice < 94) {
      send_map(model, now);
    } else if (dice < 98) {
      model.take(status(epoch_, status_t::STATE_TRACKING), now);
    } else if (dice == 98) {
      begin(epoch_, map_id_ + 1);
    } else if (random_() % 2 == 0) {
      begin(epoch_ + 1, 1);
    }
  }

 private:
  static constexpr TrackingState kTracking = TrackingState::kTracking;

  void begin(std::int64_t epoch, std::int64_t map_id) {
    map_id_ = map_id;
    if (epoch_ != epoch) seq_ = 0;
    is_whole_ = true;
    epoch_ = epoch;
    keyframes_ = 0;
  }
  void send_map(ViewModel& model, ViewModel::Clock::time_point now) {
    MapUpdate update;
    update.map_id = map_id_;
    update.base_seq = std::exchange(is_whole_, false) ? -1 : seq_;
    update.seq = ++seq_;
    update.keyframes.push_back({keyframes_, 1000 * keyframes_, somewhere()});
    update.keyframes.push_back({below(keyframes_ + 1), 1000, somewhere()});
    for (int i = 0; i < 30; ++i)
      add_landmark(below(10 * (keyframes_ + 1)), below(keyframes_ + 1),
                   static_cast<double>(below(5) + 1), update);
    for (int i = 0; i < 5; ++i) update.removed_landmarks.push_back(below(10 * (keyframes_ + 1)));
    ++keyframes_;
    for (const map_part_t& one : publishing_.publish(update, epoch_, 1024)) model.take(one, now);
  }
  std::int64_t below(std::int64_t n) { return static_cast<std::int64_t>(random_()) % n; }
  Rigid3 somewhere() {
    const auto at = static_cast<double>(below(1000));
    return {so3_exp({at, 1, 0}), {at / 7, 0, at}};
  }

  std::mt19937 random_;
  std::int64_t epoch_ = 1, map_id_ = 1, seq_ = 0, keyframes_ = 0;
  bool is_whole_ = true;
  Publishing publishing_;
  int time_ = 0;
};

TEST(ViewModel, ALatePageEqualsAnEarlyOne) {
  int largest = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    std::mt19937 random(seed);
    RandomServer server(seed);
    ViewModel model(kStart);
    std::vector<PageCopy> pages(1);
    for (int i = 0; i < 600; ++i) {
      const auto now = kStart + 50ms * i;
      server.step(model, now);
      if (random() % 40 == 0) {
        pages.emplace_back();
        pages.back().apply(model.snapshot());
      }
      if (random() % 5 != 0) continue;
      const std::string increment = model.take_increment(now);
      if (increment.empty()) continue;
      for (PageCopy& page : pages) page.apply(increment);
    }
    if (const std::string last = model.take_increment(kStart + 1h); !last.empty())
      for (PageCopy& page : pages) page.apply(last);
    pages.emplace_back();
    pages.back().apply(model.snapshot());
    EXPECT_GT(pages.size(), 5u);
    for (const PageCopy& page : pages) ASSERT_EQ(page, pages.front()) << "seed " << seed;
    largest = std::max(largest, static_cast<int>(pages.front().landmarks.size()));
  }
  EXPECT_GT(largest, 100);  // there was something to compare
}

}  // namespace
}  // namespace eifmap
