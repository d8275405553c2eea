#include "command/secret.h"

#include <fcntl.h>
#include <openssl/crypto.h>
#include <openssl/evp.h>
#include <openssl/hmac.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

namespace eifmap {
namespace {

class File {
 public:
  // Without waiting for who writes to a pipe.
  explicit File(const std::filesystem::path& path)
      : descriptor_(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {}
  ~File() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  int descriptor() const { return descriptor_; }

 private:
  int descriptor_;
};

std::string size_problem(std::size_t size) {
  return "holds " + std::to_string(size) + " bytes, wanted " + std::to_string(Secret::kFewest) +
         " to " + std::to_string(Secret::kMost) + "; make one: head -c 32 /dev/urandom | base64";
}

// Of the open file, so that nobody changes it in between.
std::string mode_problem(int descriptor) {
  struct stat about {};
  if (fstat(descriptor, &about) != 0) return std::string("cannot be read: ") + strerror(errno);
  if (!S_ISREG(about.st_mode)) return "is no file";
  if ((about.st_mode & S_IROTH) != 0) return "others can read it; chmod 600 it";
  if ((about.st_mode & (S_IWGRP | S_IWOTH)) != 0) return "others can write it; chmod 600 it";
  return "";
}

// One byte more than there may be tells that there are too many.
std::string read_bytes(int descriptor, std::vector<std::uint8_t>& bytes) {
  bytes.resize(Secret::kMost + 2);
  std::size_t size = 0;
  while (size < bytes.size()) {
    const ssize_t more = ::read(descriptor, bytes.data() + size, bytes.size() - size);
    if (more < 0 && errno == EINTR) continue;
    if (more < 0) return std::string("cannot be read: ") + strerror(errno);
    if (more == 0) break;
    size += static_cast<std::size_t>(more);
  }
  bytes.resize(size);
  if (!bytes.empty() && bytes.back() == '\n') bytes.pop_back();
  if (!bytes.empty() && bytes.back() == '\r') bytes.pop_back();
  return "";
}

bool good_size(std::size_t size) {
  return size >= Secret::kFewest && size <= Secret::kMost;
}

}  // namespace

Secret::Secret(std::vector<std::uint8_t> bytes) : bytes_(std::move(bytes)) {
  if (!good_size(bytes_.size()))
    throw std::invalid_argument("secret: " + size_problem(bytes_.size()));
}

Secret::~Secret() {
  OPENSSL_cleanse(bytes_.data(), bytes_.size());
}

Mac Secret::mac(Bytes message) const {
  Mac mac{};
  unsigned size = static_cast<unsigned>(mac.size());
  if (!HMAC(EVP_sha256(), bytes_.data(), static_cast<int>(bytes_.size()), message.data(),
            message.size(), mac.data(), &size) ||
      size != mac.size())
    throw std::runtime_error("HMAC-SHA256: libcrypto cannot");
  return mac;
}

bool same_mac(Bytes a, Bytes b) {
  return a.size() == b.size() && CRYPTO_memcmp(a.data(), b.data(), a.size()) == 0;
}

SecretFile read_secret(const std::filesystem::path& path) {
  const auto refuse = [&path](const std::string& why) {
    SecretFile refused;
    refused.problem = "the secret in " + path.string() + ": " + why;
    return refused;
  };
  const File file(path);
  if (file.descriptor() < 0) return refuse(std::string("cannot be read: ") + strerror(errno));
  if (const std::string problem = mode_problem(file.descriptor()); !problem.empty())
    return refuse(problem);
  std::vector<std::uint8_t> bytes;
  bytes.reserve(Secret::kMost + 2);  // else parts of it would be left where it had lain
  std::string problem = read_bytes(file.descriptor(), bytes);
  if (problem.empty() && !good_size(bytes.size())) problem = size_problem(bytes.size());
  if (!problem.empty()) {
    OPENSSL_cleanse(bytes.data(), bytes.size());
    return refuse(problem);
  }
  SecretFile read;
  read.secret.emplace(std::move(bytes));
  return read;
}

}  // namespace eifmap
