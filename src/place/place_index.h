// Which of the images seen before show what this one shows? Without a vocabulary file: words are
// learnt from the first images (words.h), an image is one vector of bytes (signature.h), and a
// query compares it with all of them.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "frame.h"
#include "place/signature.h"
#include "shared_vector.h"

namespace eifmap {

struct PlaceOptions {
  // Images whose descriptors the words are learnt from; until then the index knows no place.
  int learn_from = 10;
  // Of k-means: with none a word is one of the descriptors, not the middle of those it is nearest
  // to, and how many these are tells in the signature. Half of a recorded kitchen asked for the
  // other half: among the best 5 was one from within .5 m and 25 degrees for 84 to 92 % of the
  // images, and for 82 % with 1 or 4 of them.
  int iterations = 0;
  std::uint64_t seed = 1;  // of the choice of words

  std::string problem() const;  // "" or which field is wrong and why
};

struct PlaceScore {
  int id = 0;
  // 1: the same image. Images of different places have something in common, too: how often each
  // word is the nearest.
  double score = 0;
};

// What an index knows once it is ready, for a file: of each image what the words make of it.
struct PlaceBooks {
  std::shared_ptr<const SplitWords> words;  // null: not ready, and to be filled by add() again
  std::vector<std::pair<int, Signature>> signatures;  // by id
};

// Copies share what they hold: one costs pointers, however many images there are.
class PlaceIndex {
 public:
  explicit PlaceIndex(const PlaceOptions& options = {});  // throws std::invalid_argument

  // Throws std::invalid_argument where `id` is negative or in the index, or where the frame has not
  // one descriptor per keypoint; the index is then as it was.
  void add(int id, const FeatureFrame& frame);
  // Throws std::invalid_argument where there is no such image.
  void remove(int id);

  bool contains(int id) const;
  int size() const { return size_; }
  bool ready() const { return words_ != nullptr; }  // the words are learnt

  // For a map that is kept in a file. The words (null: not ready), and what they make of an image
  // that is in the index; throws std::invalid_argument where it is not, or nothing is ready.
  const std::shared_ptr<const SplitWords>& words() const { return words_; }
  const Signature& signature(int id) const;
  // Of an index that has no image yet, else std::invalid_argument; and where ids are not different
  // ones, 0 or more.
  void restore(PlaceBooks books);

  // The most similar `count` (>= 0, else std::invalid_argument), best first; of equal ones the
  // lower id. Fewer where there are not so many, none before it is ready. Throws as add() does for
  // the frame.
  std::vector<PlaceScore> query(const FeatureFrame& frame, int count) const;

 private:
  struct Waiting {
    int id = 0;
    std::shared_ptr<const SplitFeatures> features;
  };
  void learn();
  void put(int id, const Signature& signature);

  PlaceOptions options_;
  std::vector<Waiting> waiting_;  // until the words are learnt
  std::shared_ptr<const SplitWords> words_;
  // Slots; that of a removed image waits for another.
  SharedVector<int, 256> ids_;  // or kFree
  SharedVector<Signature, 4> signatures_;
  int size_ = 0;
};

}  // namespace eifmap
