// Values to bytes and back, for files: little-endian, as they are in memory, nothing between them.
// One function visits a type's fields for both.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <map>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace eifmap {

static_assert(std::endian::native == std::endian::little, "files are little-endian");

template <class T>
concept PlainValue = std::is_arithmetic_v<T> || std::is_enum_v<T>;

class ByteWriter {
 public:
  static constexpr bool kReads = false;
  const std::vector<std::uint8_t>& bytes() const { return bytes_; }
  std::vector<std::uint8_t> take() { return std::exchange(bytes_, {}); }
  void clear() { bytes_.clear(); }
  void reserve(std::size_t size) { bytes_.reserve(size); }
  void append(const void* data, std::size_t size) {
    if (size == 0) return;
    const std::size_t at = bytes_.size();
    bytes_.resize(at + size);
    std::memcpy(bytes_.data() + at, data, size);
  }

  template <PlainValue T>
  void operator()(const T& value) {
    append(&value, sizeof value);
  }
  template <class T, int kRows, int kColumns, int kOptions>
  void operator()(const Eigen::Matrix<T, kRows, kColumns, kOptions>& matrix) {
    static_assert(kRows > 0 && kColumns > 0);
    append(matrix.data(), sizeof(T) * kRows * kColumns);
  }
  void operator()(const Eigen::Quaterniond& q) { append(q.coeffs().data(), 4 * sizeof(double)); }
  void size(std::size_t n) { (*this)(static_cast<std::uint32_t>(n)); }

 private:
  std::vector<std::uint8_t> bytes_;
};

// Never reads beyond its bytes: what is missing is 0, and ok() says so.
class ByteReader {
 public:
  static constexpr bool kReads = true;
  explicit ByteReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}
  bool ok() const { return ok_; }
  bool is_whole() const { return ok_ && bytes_.empty(); }  // all was read and nothing was missing

  void take(void* to, std::size_t size) {
    if (size > bytes_.size()) {
      ok_ = false;
      bytes_ = {};
    }
    if (size == 0) return;
    if (!ok_) return static_cast<void>(std::memset(to, 0, size));
    std::memcpy(to, bytes_.data(), size);
    bytes_ = bytes_.subspan(size);
  }
  template <PlainValue T>
  void operator()(T& value) {
    if constexpr (std::is_same_v<T, bool>) {
      std::uint8_t byte = 0;
      take(&byte, 1);
      value = byte != 0;
    } else {
      take(&value, sizeof value);
    }
  }
  template <class T, int kRows, int kColumns, int kOptions>
  void operator()(Eigen::Matrix<T, kRows, kColumns, kOptions>& matrix) {
    static_assert(kRows > 0 && kColumns > 0);
    take(matrix.data(), sizeof(T) * kRows * kColumns);
  }
  void operator()(Eigen::Quaterniond& q) { take(q.coeffs().data(), 4 * sizeof(double)); }
  // Of so many elements, each of at least so many bytes: 0 where there is no room for them.
  std::size_t size(std::size_t least_bytes) {
    std::uint32_t n = 0;
    (*this)(n);
    if (n * static_cast<std::uint64_t>(least_bytes) > bytes_.size()) ok_ = false;
    return ok_ ? n : 0;
  }

 private:
  std::span<const std::uint8_t> bytes_;
  bool ok_ = true;
};

// Elements one after the other, each visited by `visit(io, element)`. `least_bytes`: of an element.
template <class Io, class Vector, class Visit>
void visit_all(Io& io, Vector& elements, std::size_t least_bytes, Visit visit) {
  if constexpr (Io::kReads)
    elements.resize(io.size(least_bytes));
  else
    io.size(elements.size());
  for (auto& element : elements) visit(io, element);
}

// The same of plain values, at once.
template <class Io, class Vector>
void visit_plain(Io& io, Vector& elements) {
  using T = typename std::remove_cvref_t<Vector>::value_type;
  static_assert(PlainValue<T>);
  if constexpr (Io::kReads) {
    elements.resize(io.size(sizeof(T)));
    io.take(elements.data(), elements.size() * sizeof(T));
  } else {
    io.size(elements.size());
    io.append(elements.data(), elements.size() * sizeof(T));
  }
}

}  // namespace eifmap
