#include "wire/layout.h"

#include <algorithm>
#include <limits>

namespace eifmap {
namespace {

constexpr std::size_t kFingerprintSize = 8;

std::uint64_t big_endian(Bytes bytes) {
  std::uint64_t value = 0;
  for (const std::uint8_t byte : bytes) value = value << 8 | byte;
  return value;
}

std::int32_t int32_at(Bytes bytes, std::size_t position) {
  return static_cast<std::int32_t>(big_endian(bytes.subspan(position, 4)));
}

}  // namespace

LayoutScanner::LayoutScanner(Bytes bytes, std::int64_t fingerprint) : bytes_(bytes) {
  if (bytes.size() > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()))
    fail("a message of " + std::to_string(bytes.size()) + " bytes");
  else if (bytes.size() < kFingerprintSize)
    fail(std::to_string(bytes.size()) + " bytes are too few for a message");
  else if (big_endian(bytes.first(kFingerprintSize)) != static_cast<std::uint64_t>(fingerprint))
    fail("the fingerprint is another message type's");
  else
    position_ = kFingerprintSize;
}

void LayoutScanner::fail(std::string problem) {
  if (ok()) problem_ = std::move(problem);
}

void LayoutScanner::skip(std::size_t size) {
  if (!ok()) return;
  if (size > remaining()) return fail("cut off after " + std::to_string(bytes_.size()) + " bytes");
  position_ += size;
}

std::size_t LayoutScanner::count(const char* name, std::size_t max) {
  const std::size_t at = position_;
  skip(4);
  if (!ok()) return 0;
  const std::int32_t value = int32_at(bytes_, at);
  if (value < 0 || static_cast<std::size_t>(value) > max) {
    fail(std::string(name) + " is " + std::to_string(value) + ", must be 0 to " +
         std::to_string(max));
    return 0;
  }
  return static_cast<std::size_t>(value);
}

void LayoutScanner::array(const char* name, std::size_t count, std::size_t entry_size) {
  if (!ok()) return;
  if (count > remaining() / entry_size)
    return fail(std::string(name) + ": " + std::to_string(count) + " entries of " +
                std::to_string(entry_size) + " bytes, but only " + std::to_string(remaining()) +
                " bytes are left");
  position_ += count * entry_size;
}

void LayoutScanner::string(const char* name, std::size_t max) {
  const std::size_t length = count(name, max + 1);
  const std::size_t at = position_;
  skip(length);
  if (!ok()) return;
  const Bytes text = bytes_.subspan(at, length);
  if (std::find(text.begin(), text.end(), 0) != text.end() - 1 || length == 0)
    fail(std::string(name) + " is not a string that ends with its only NUL");
}

std::string LayoutScanner::finish() {
  if (ok() && remaining() > 0)
    fail(std::to_string(remaining()) + " bytes too many after the message's end");
  return problem_;
}

}  // namespace eifmap
