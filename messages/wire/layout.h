// The sizes inside an encoded message, checked against its bytes before anything is decoded: the
// generated decoders allocate whatever a count field says, and liblcm passes on whatever arrives.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "wire/bytes.h"

namespace eifmap {

// Walks over the big-endian bytes of a message. The first thing that does not fit is kept as the
// problem; every later step does nothing, so that a layout reads as straight as its schema.
class LayoutScanner {
 public:
  LayoutScanner(Bytes bytes, std::int64_t fingerprint);

  // Steps over fixed-size fields of `size` bytes together.
  void skip(std::size_t size);
  // A count field: 0 <= count <= max, else a problem and 0.
  std::size_t count(const char* name, std::size_t max);
  // Steps over `count` entries of `entry_size` bytes.
  void array(const char* name, std::size_t count, std::size_t entry_size);
  // A string: its length with the terminating NUL, the bytes, the NUL; no NUL inside.
  void string(const char* name, std::size_t max);

  bool ok() const { return problem_.empty(); }
  // "" when every byte was accounted for.
  std::string finish();

 private:
  void fail(std::string problem);
  std::size_t remaining() const { return bytes_.size() - position_; }

  Bytes bytes_;
  std::size_t position_ = 0;
  std::string problem_;
};

// Decodes with the generated decoder after `scan` has walked over the message and found that it
// fits. kMalformedMessage otherwise.
template <class Message>
Decoded<Message> decode_checked(Bytes bytes, void (*scan)(LayoutScanner&)) {
  LayoutScanner scanner(bytes, Message::getHash());
  scan(scanner);
  if (std::string problem = scanner.finish(); !problem.empty())
    return Decoded<Message>::refuse(Reason::kMalformedMessage, std::move(problem));
  Decoded<Message> result;
  try {
    const int size = static_cast<int>(bytes.size());
    if (result.value.decode(bytes.data(), 0, size) == size) return result;
  } catch (const std::exception&) {
    // Told below: the layout and the generated decoder disagree.
  }
  return Decoded<Message>::refuse(Reason::kMalformedMessage, "the decoder refused the bytes");
}

// The same, and then `problem` is asked what is wrong with the values: "" nothing.
template <class Message>
Decoded<Message> decode_checked(Bytes bytes, void (*scan)(LayoutScanner&),
                                std::string (*problem)(const Message&)) {
  Decoded<Message> decoded = decode_checked<Message>(bytes, scan);
  if (!decoded.ok()) return decoded;
  if (std::string found = problem(decoded.value); !found.empty())
    return Decoded<Message>::refuse(Reason::kMalformedMessage, std::move(found));
  return decoded;
}

}  // namespace eifmap
