// A secret that server and operators share, and the signatures made with it: HMAC-SHA256 over a
// message encoded without its mac. Who signs, and of which type the message is (its fingerprint),
// is in what is signed; that it is not an old one sent again is for the receiver to see.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "command/command_message.h"
#include "wire/bytes.h"

namespace eifmap {

using Mac = std::array<std::uint8_t, kMacBytes>;

class Secret {
 public:
  static constexpr std::size_t kFewest = 16, kMost = 4096;  // bytes

  // Throws std::invalid_argument where they are too few or too many.
  explicit Secret(std::vector<std::uint8_t> bytes);
  ~Secret();  // wipes it
  Secret(const Secret&) = delete;
  Secret& operator=(const Secret&) = delete;
  Secret(Secret&&) noexcept = default;

  Mac mac(Bytes message) const;  // throws std::runtime_error where libcrypto fails

 private:
  std::vector<std::uint8_t> bytes_;
};

struct SecretFile {
  std::optional<Secret> secret;
  std::string problem;  // "" or what is wrong with the file, and what to do
};

// The bytes of a file without the line's end behind them. Refused: what is no file, or others than
// its owner and group can read or others than its owner can write, and too few or too many bytes.
SecretFile read_secret(const std::filesystem::path& file);

// In time that does not depend on where they differ.
bool same_mac(Bytes a, Bytes b);

// `Message`: command_t or reply_t.
template <class Message>
void sign(Message& message, const Secret& secret) {
  message.mac.clear();
  message.mac_size = 0;
  const Mac mac = secret.mac(encode(message));
  message.mac.assign(mac.begin(), mac.end());
  message.mac_size = static_cast<std::int32_t>(mac.size());
}

template <class Message>
bool is_signed_by(Message message, const Secret& secret) {
  const std::vector<std::uint8_t> mac(message.mac.begin(), message.mac.end());
  if (mac.size() != kMacBytes) return false;
  sign(message, secret);
  const std::vector<std::uint8_t> right(message.mac.begin(), message.mac.end());
  return same_mac(mac, right);
}

}  // namespace eifmap
