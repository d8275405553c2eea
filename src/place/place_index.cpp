#include "place/place_index.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace eifmap {
namespace {

constexpr int kFree = -1;

SplitFeatures split(const FeatureFrame& frame) {
  if (frame.descriptors.size() != frame.keypoints.size() * kDescriptorSize)
    throw std::invalid_argument("PlaceIndex: " + std::to_string(frame.keypoints.size()) +
                                " keypoints and " + std::to_string(frame.descriptors.size()) +
                                " bytes of descriptors");
  return {features_of_sign(frame, -1), features_of_sign(frame, 1)};
}

void append(std::vector<std::int8_t>& all, const FeatureGroup& more) {
  all.insert(all.end(), more.descriptors.begin(), more.descriptors.end());
}

}  // namespace

std::string PlaceOptions::problem() const {
  if (learn_from < 1) return "learn_from is " + std::to_string(learn_from) + ", wanted 1 or more";
  if (iterations < 0) return "iterations is " + std::to_string(iterations) + ", wanted 0 or more";
  return "";
}

PlaceIndex::PlaceIndex(const PlaceOptions& options) : options_(options) {
  if (const std::string problem = options.problem(); !problem.empty())
    throw std::invalid_argument("PlaceOptions: " + problem);
}

bool PlaceIndex::contains(int id) const {
  return std::any_of(waiting_.begin(), waiting_.end(),
                     [id](const Waiting& waiting) { return waiting.id == id; }) ||
         (id != kFree && std::find(ids_.begin(), ids_.end(), id) != ids_.end());
}

void PlaceIndex::add(int id, const FeatureFrame& frame) {
  if (id < 0 || contains(id))
    throw std::invalid_argument("PlaceIndex::add: " + std::to_string(id) +
                                " is negative or there already");
  SplitFeatures features = split(frame);
  if (ready()) {
    put(id, describe(features, *words_));
  } else {
    waiting_.push_back({id, std::make_shared<const SplitFeatures>(std::move(features))});
    if (static_cast<int>(waiting_.size()) >= options_.learn_from) learn();
  }
  ++size_;
}

void PlaceIndex::learn() {
  std::vector<std::int8_t> minus, plus;
  for (const Waiting& waiting : waiting_) {
    append(minus, waiting.features->minus);
    append(plus, waiting.features->plus);
  }
  words_ = std::make_shared<const SplitWords>(
      SplitWords{learn_words(minus, options_.iterations, options_.seed),
                 learn_words(plus, options_.iterations, options_.seed)});
  for (const Waiting& waiting : waiting_) put(waiting.id, describe(*waiting.features, *words_));
  waiting_.clear();
}

void PlaceIndex::put(int id, const Signature& signature) {
  std::size_t slot = 0;
  while (slot < ids_.size() && ids_[slot] != kFree) ++slot;
  if (slot == ids_.size()) {
    ids_.push_back(id);
    signatures_.push_back(signature);
  } else {
    ids_.write(slot) = id;
    signatures_.write(slot) = signature;
  }
}

void PlaceIndex::remove(int id) {
  const auto none_left = std::erase_if(waiting_, [id](const Waiting& w) { return w.id == id; });
  if (none_left == 0) {
    std::size_t slot = 0;
    while (slot < ids_.size() && ids_[slot] != id) ++slot;
    if (id == kFree || slot == ids_.size())
      throw std::invalid_argument("PlaceIndex::remove: no image " + std::to_string(id));
    ids_.write(slot) = kFree;
  }
  --size_;
}

const Signature& PlaceIndex::signature(int id) const {
  for (std::size_t slot = 0; slot < ids_.size(); ++slot)
    if (id != kFree && ids_[slot] == id) return signatures_[slot];
  throw std::invalid_argument("PlaceIndex::signature: no image " + std::to_string(id));
}

void PlaceIndex::restore(PlaceBooks books) {
  std::vector<int> ids;
  for (const auto& [id, signature] : books.signatures) ids.push_back(id);
  std::sort(ids.begin(), ids.end());
  if (size_ > 0 || (!books.words && !ids.empty()) || (!ids.empty() && ids.front() < 0) ||
      std::adjacent_find(ids.begin(), ids.end()) != ids.end())
    throw std::invalid_argument("PlaceIndex::restore: not empty, no words, or such ids");
  words_ = std::move(books.words);
  for (const auto& [id, signature] : books.signatures) {
    ids_.push_back(id);
    signatures_.push_back(signature);
  }
  size_ = static_cast<int>(ids.size());
}

std::vector<PlaceScore> PlaceIndex::query(const FeatureFrame& frame, int count) const {
  if (count < 0) throw std::invalid_argument("PlaceIndex::query: a negative count");
  const SplitFeatures features = split(frame);
  if (!ready()) return {};
  const Signature signature = describe(features, *words_);
  std::vector<std::pair<int, int>> found;  // similarity negated, id
  found.reserve(ids_.size());
  for (std::size_t slot = 0; slot < ids_.size(); ++slot)
    if (ids_[slot] != kFree)
      found.emplace_back(-similarity(signature, signatures_[slot]), ids_[slot]);
  const auto end =
      found.begin() + std::min<std::ptrdiff_t>(count, static_cast<std::ptrdiff_t>(found.size()));
  std::partial_sort(found.begin(), end, found.end());
  std::vector<PlaceScore> best;
  for (auto place = found.begin(); place != end; ++place)
    best.push_back({place->second, -place->first / (2 * kSignatureScale * kSignatureScale)});
  return best;
}

}  // namespace eifmap
