// A vector in pieces that its copies share until one of them writes to a piece: a copy of a large
// map costs what becomes another in it, not what it holds.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

namespace eifmap {

// `kPiece` elements are shared or copied together. Elements are read through const access alone;
// write() says that one is to become another, and what it returns is valid until the vector is
// copied. References to elements of the same piece that were read before are not valid after it.
//
// Two copies may be used in two threads, as two std::vectors may, and one may be copied while it is
// read. A vector writes only to pieces that it made itself since it was last copied, whoever else
// still has the others: that nobody else has a piece any more cannot be told safely while another
// thread may be reading it, and would depend on the threads' order.
template <class T, std::size_t kPiece>
class SharedVector {
 public:
  class Iterator {
   public:
    using iterator_category = std::forward_iterator_tag;
    using value_type = T;
    using difference_type = std::ptrdiff_t;
    using pointer = const T*;
    using reference = const T&;
    Iterator() = default;
    Iterator(const SharedVector* of, std::size_t at) : of_(of), at_(at) {}
    reference operator*() const { return (*of_)[at_]; }
    pointer operator->() const { return &(*of_)[at_]; }
    Iterator& operator++() {
      ++at_;
      return *this;
    }
    Iterator operator++(int) { return {of_, at_++}; }
    bool operator==(const Iterator&) const = default;

   private:
    const SharedVector* of_ = nullptr;
    std::size_t at_ = 0;
  };

  SharedVector() = default;
  SharedVector(const SharedVector& other) : pieces_(other.pieces_), size_(other.size_) {
    other.share();
  }
  SharedVector& operator=(const SharedVector& other) {
    if (this == &other) return *this;
    pieces_ = other.pieces_;
    size_ = other.size_;
    share();
    other.share();
    return *this;
  }
  SharedVector(SharedVector&& other) noexcept { swap(other); }
  SharedVector& operator=(SharedVector&& other) noexcept {
    if (this == &other) return *this;
    SharedVector empty;
    swap(other);
    other.swap(empty);
    return *this;
  }
  ~SharedVector() = default;

  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  const T& operator[](std::size_t i) const { return pieces_[i / kPiece]->items[i % kPiece]; }
  const T& at(std::size_t i) const {
    if (i >= size_) throw std::out_of_range("SharedVector::at");
    return (*this)[i];
  }
  const T& back() const { return (*this)[size_ - 1]; }
  Iterator begin() const { return {this, 0}; }
  Iterator end() const { return {this, size_}; }

  T& write(std::size_t i) {
    Piece& piece = own(i / kPiece);
    piece.blank.reset(i % kPiece);
    return piece.items[i % kPiece];
  }
  T& write_back() { return write(size_ - 1); }

  // Grows by T(), to stay so.
  void extend(std::size_t size) {
    while (size_ < size) {
      if (size_ % kPiece == 0 && size - size_ >= kPiece) {
        pieces_.push_back(blank_piece());
        size_ += kPiece;
      } else {
        push_back(T());
        reset(size_ - 1);
      }
    }
  }

  // Element i becomes T(), to stay so. A piece in which all have become so costs nothing any more:
  // all vectors share one.
  void reset(std::size_t i) {
    if (pieces_[i / kPiece]->blank[i % kPiece]) return;
    write(i) = T();
    Piece& piece = own(i / kPiece);
    piece.blank.set(i % kPiece);
    if (piece.blank.all()) pieces_[i / kPiece] = blank_piece();
  }

  void push_back(T item) {
    if (size_ % kPiece == 0) {
      pieces_.push_back(std::make_shared<Piece>());
      pieces_.back()->owner = owner();
    }
    write(size_) = std::move(item);
    ++size_;
  }
  // Keeps the order; returns how many went.
  template <class Predicate>
  std::size_t erase_if(Predicate predicate) {
    std::size_t left = 0;
    for (std::size_t i = 0; i < size_; ++i) {
      if (predicate((*this)[i])) continue;
      if (left != i) {
        T item = (*this)[i];  // a piece that is written to may go
        write(left) = std::move(item);
      }
      ++left;
    }
    const std::size_t gone = size_ - left;
    while (size_ > left) {
      --size_;
      if (size_ % kPiece == 0)
        pieces_.pop_back();
      else if (pieces_.back()->owner == owner())
        write(size_) = T();
    }
    return gone;
  }

  // Whether the piece that element i is in is the same in both, and so every element of it: what a
  // copy from before need not look at again.
  bool shares_piece(std::size_t i, const SharedVector& other) const {
    return i / kPiece < other.pieces_.size() && pieces_[i / kPiece] == other.pieces_[i / kPiece];
  }
  static constexpr std::size_t piece_size() { return kPiece; }
  // Of which there is anything to hold.
  std::size_t num_pieces_held() const {
    return static_cast<std::size_t>(std::count_if(
        pieces_.begin(), pieces_.end(), [](const auto& piece) { return piece != blank_piece(); }));
  }

  // How many of its pieces it has not made itself since it was last copied.
  std::size_t num_shared_pieces() const {
    const std::uint64_t own = owner_.load(std::memory_order_relaxed);
    return static_cast<std::size_t>(std::count_if(
        pieces_.begin(), pieces_.end(), [own](const auto& piece) { return piece->owner != own; }));
  }

 private:
  struct Piece {
    std::uint64_t owner = 0;    // the name of whose it is; never changed once others may see it
    std::bitset<kPiece> blank;  // what reset() has made of it, and nobody has written to since
    std::array<T, kPiece> items{};
  };

  // Of no vector: who writes to it makes a copy.
  static const std::shared_ptr<Piece>& blank_piece() {
    static const std::shared_ptr<Piece> blank = [] {
      auto piece = std::make_shared<Piece>();
      piece->blank.set();
      return piece;
    }();
    return blank;
  }

  // From now on another may have its pieces too.
  void share() const { owner_.store(0, std::memory_order_relaxed); }
  // A name that nobody has had, until it is copied.
  std::uint64_t owner() {
    static std::atomic<std::uint64_t> last{0};
    std::uint64_t own = owner_.load(std::memory_order_relaxed);
    if (own == 0) {
      own = last.fetch_add(1, std::memory_order_relaxed) + 1;
      owner_.store(own, std::memory_order_relaxed);
    }
    return own;
  }
  Piece& own(std::size_t p) {
    const std::uint64_t own = owner();
    if (pieces_[p]->owner != own) {
      auto copy = std::make_shared<Piece>(*pieces_[p]);
      copy->owner = own;
      pieces_[p] = std::move(copy);
    }
    return *pieces_[p];
  }
  void swap(SharedVector& other) noexcept {
    pieces_.swap(other.pieces_);
    std::swap(size_, other.size_);
    const std::uint64_t mine = owner_.load(std::memory_order_relaxed);
    owner_.store(other.owner_.load(std::memory_order_relaxed), std::memory_order_relaxed);
    other.owner_.store(mine, std::memory_order_relaxed);
  }

  std::vector<std::shared_ptr<Piece>> pieces_;
  std::size_t size_ = 0;
  // 0: of no piece. Atomic since a copy is made of what other threads may be copying too.
  mutable std::atomic<std::uint64_t> owner_{0};
};

}  // namespace eifmap
