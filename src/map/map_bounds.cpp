#include "map/map_bounds.h"

#include <algorithm>
#include <map>

#include "map/map_scale.h"
#include "map/redundancy.h"

namespace eifmap {
namespace {

constexpr int kLink = 15;        // landmarks that link two keyframes: enough for a pose
constexpr int kThreeSights = 3;  // of a landmark that hands on scale
constexpr int kEnough = 30;      // landmarks that a keyframe keeps
constexpr int kAround = 8;       // keyframes of the local map, which stay
constexpr int kTried = 20;       // keyframes asked for before the map is said to be full
constexpr int kShare = 100;      // at once goes the hundredth part, since every time costs

class Links {
 public:
  explicit Links(const Map& map) : map_(map), shared_(map.num_keyframes()), gone_(shared_.size()) {
    for (int k = 0; k < map.num_keyframes(); ++k) gone_[k] = map.is_removed(k);
    for (int t = 0; t < map.num_tracks(); ++t)
      if (map.track(t).is_landmark()) count(map.track(t).sights, 1);
  }

  // Without the keyframe, or with it again.
  void take_out(int keyframe) { move(keyframe, -1), gone_[keyframe] = 1; }
  void put_back(int keyframe) { move(keyframe, 1), gone_[keyframe] = 0; }

  // Takes out a landmark, unless two keyframes are no longer linked then.
  bool drop(const std::vector<Sight>& sights) {
    if (number_left(sights) >= kThreeSights)
      for (const Sight& a : sights)
        for (const Sight& b : sights)
          if (a.keyframe < b.keyframe && shared_[a.keyframe][b.keyframe] == kLink) return false;
    count(sights, -1);
    return true;
  }

  // Depth first (R. Tarjan, SIAM J. Comput. 1, 1972): a keyframe is a cut when what was found
  // through it reaches no further back than to itself.
  MapStructure structure() const {
    MapStructure found;
    const auto n = shared_.size();
    std::vector<int> order(n, 0), reaches(n, 0), parent(n, -1);
    std::vector<std::uint8_t> is_cut(n, 0);
    using Neighbour = std::map<int, int>::const_iterator;
    struct Visit {
      int keyframe = 0;
      Neighbour next;
    };
    int visited = 0;
    for (int root = 0; root < static_cast<int>(n); ++root) {
      if (gone_[root] || order[root] > 0) continue;
      ++found.parts;
      int branches = 0;
      std::vector<Visit> path{{root, shared_[root].begin()}};
      order[root] = reaches[root] = ++visited;
      while (!path.empty()) {
        const int k = path.back().keyframe;
        Neighbour& next = path.back().next;
        if (next == shared_[k].end()) {
          path.pop_back();
          const int above = parent[k];
          if (above < 0) continue;
          reaches[above] = std::min(reaches[above], reaches[k]);
          if (above != root && reaches[k] >= order[above]) is_cut[above] = 1;
          if (above == root) ++branches;
          continue;
        }
        const auto [j, landmarks] = *next++;
        if (landmarks < kLink || gone_[j]) continue;
        if (order[j] == 0) {
          parent[j] = k;
          order[j] = reaches[j] = ++visited;
          path.push_back({j, shared_[j].begin()});
        } else if (j != parent[k]) {
          reaches[k] = std::min(reaches[k], order[j]);
        }
      }
      if (branches > 1) is_cut[root] = 1;
    }
    found.cuts = static_cast<int>(std::count(is_cut.begin(), is_cut.end(), 1));
    return found;
  }

 private:
  int number_left(const std::vector<Sight>& sights) const {
    return static_cast<int>(std::count_if(sights.begin(), sights.end(),
                                          [this](const Sight& s) { return !gone_[s.keyframe]; }));
  }

  void count(const std::vector<Sight>& sights, int sign) {
    if (number_left(sights) < kThreeSights) return;
    for (const Sight& a : sights)
      for (const Sight& b : sights)
        if (a.keyframe != b.keyframe) shared_[a.keyframe][b.keyframe] += sign;
  }

  // What links others through landmarks that have three sights with it alone.
  void move(int keyframe, int sign) {
    for (const int t : map_.keyframe(keyframe).track) {
      if (t == kNoTrack || !map_.track(t).is_landmark()) continue;
      const std::vector<Sight>& sights = map_.track(t).sights;
      gone_[keyframe] = 0;
      if (number_left(sights) == kThreeSights) count(sights, sign);
    }
  }

  const Map& map_;
  std::vector<std::map<int, int>> shared_;  // by keyframe: landmarks with others
  std::vector<std::uint8_t> gone_;
};

std::vector<int> most_redundant_first(const Map& map, int reference) {
  std::vector<int> stays = map.covisible(reference, kAround);
  stays.push_back(map.newest());
  std::vector<std::pair<double, int>> ranked;
  for (int k = 2; k < map.num_keyframes(); ++k)
    if (!map.is_removed(k) && is_spare(map, k) &&
        std::find(stays.begin(), stays.end(), k) == stays.end())
      ranked.emplace_back(-redundancy(map, k, kThreeSights), k);
  std::sort(ranked.begin(), ranked.end());
  std::vector<int> keyframes;
  for (const auto& [rank, k] : ranked) keyframes.push_back(k);
  return keyframes;
}

bool worse(const MapStructure& a, const MapStructure& b) {
  return a.parts > b.parts || a.cuts > b.cuts;
}

// Landmarks of each keyframe.
std::vector<int> landmark_counts(const Map& map) {
  std::vector<int> counts(map.num_keyframes(), 0);
  for (int t = 0; t < map.num_tracks(); ++t)
    if (map.track(t).is_landmark())
      for (const Sight& s : map.track(t).sights) ++counts[s.keyframe];
  return counts;
}

}  // namespace

MapStructure map_structure(const Map& map, int without) {
  Links links(map);
  if (without >= 0) links.take_out(without);
  return links.structure();
}

bool is_crowded(const Map& map, const BoundOptions& options) {
  return options.max_landmarks > 0 && map.num_landmarks() > options.max_landmarks;
}

int make_room(Map& map, int reference, const BoundOptions& options) {
  const int excess = map.num_keyframes_in_use() + 1 - options.max_keyframes;
  int wanted = is_crowded(map, options) ? 1 : 0;
  if (options.max_keyframes > 0 && excess > 0)
    wanted = excess - 1 + std::max(1, options.max_keyframes / kShare);
  int removed = 0;
  // In turns: what is redundant changes with each that goes.
  while (removed < wanted) {
    Links links(map);
    const MapStructure now = links.structure();
    const std::vector<int> candidates = most_redundant_first(map, reference);
    int found = -1;
    for (int i = 0; i < std::min(kTried, static_cast<int>(candidates.size())) && found < 0; ++i) {
      links.take_out(candidates[i]);
      if (!worse(links.structure(), now)) found = candidates[i];
      links.put_back(candidates[i]);
    }
    if (found < 0) break;
    map.remove_keyframe(found);
    ++removed;
  }
  return removed;
}

int drop_landmarks(Map& map, int newest, const BoundOptions& options) {
  if (!is_crowded(map, options)) return 0;
  const int wanted =
      map.num_landmarks() - options.max_landmarks + std::max(1, options.max_landmarks / kShare);
  struct Rank {
    bool in_view = false;
    std::size_t sights = 0;
    int last = 0, track = 0;
    auto operator<=>(const Rank&) const = default;
  };
  const std::vector<int> measured = map.measured_tracks();
  const std::vector<int> in_view = map.landmarks_of(map.covisible(newest, kAround));
  std::vector<Rank> ranked;
  for (int t = 0; t < map.num_tracks(); ++t) {
    const Track& track = map.track(t);
    if (track.is_landmark() && !std::binary_search(measured.begin(), measured.end(), t))
      ranked.push_back({std::binary_search(in_view.begin(), in_view.end(), t), track.sights.size(),
                        track.sights.back().keyframe, t});
  }
  std::sort(ranked.begin(), ranked.end());
  std::vector<int> left = landmark_counts(map);
  Links links(map);
  int dropped = 0;
  for (const Rank& rank : ranked) {
    if (dropped == wanted) break;
    const std::vector<Sight> sights = map.track(rank.track).sights;
    if (std::any_of(sights.begin(), sights.end(),
                    [&left](const Sight& s) { return left[s.keyframe] <= kEnough; }) ||
        !links.drop(sights))
      continue;
    for (const Sight& s : sights) --left[s.keyframe];
    map.remove_track(rank.track);
    ++dropped;
  }
  return dropped;
}

}  // namespace eifmap
