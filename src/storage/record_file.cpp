#include "storage/record_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string_view>
#include <utility>

#include "storage/byte_stream.h"
#include "storage/hash.h"

namespace eifmap {
namespace {

constexpr std::string_view kMark = "EIFMAP\r\n";
constexpr std::uint32_t kRecordMark = 0x52464945;  // EIFR
constexpr std::size_t kHeaderSize = 32, kRecordHeaderSize = 32;

std::string failure(const std::string& what, const std::filesystem::path& file) {
  return what + " " + file.string() + ": " + std::strerror(errno);
}

std::vector<std::uint8_t> file_header(std::uint64_t name) {
  ByteWriter out;
  out.append(kMark.data(), kMark.size());
  out(kFileVersion);
  out(std::uint32_t{0});
  out(name);
  out(hash_bytes(out.bytes(), 0));
  return out.bytes();
}

std::uint64_t record_hash(std::uint64_t name, std::uint64_t number,
                          std::span<const std::uint8_t> record) {
  ByteWriter out;
  out(number);
  out(static_cast<std::uint64_t>(record.size()));
  return hash_bytes(record, hash_bytes(out.bytes(), name));
}

std::vector<std::uint8_t> record_header(std::uint64_t name, std::uint64_t number,
                                        std::span<const std::uint8_t> record) {
  ByteWriter out;
  out(kRecordMark);
  out(std::uint32_t{0});
  out(number);
  out(static_cast<std::uint64_t>(record.size()));
  out(record_hash(name, number, record));
  return out.bytes();
}

struct RecordAt {
  bool whole = false;
  std::uint64_t number = 0;
  std::span<const std::uint8_t> bytes;
};

RecordAt record_at(std::span<const std::uint8_t> rest, std::uint64_t name) {
  if (rest.size() < kRecordHeaderSize) return {};
  ByteReader in(rest.first(kRecordHeaderSize));
  std::uint32_t mark = 0, zero = 0;
  std::uint64_t size = 0, hash = 0;
  RecordAt record;
  in(mark), in(zero), in(record.number), in(size), in(hash);
  if (mark != kRecordMark || zero != 0 || size > rest.size() - kRecordHeaderSize) return {};
  record.bytes = rest.subspan(kRecordHeaderSize, size);
  record.whole = hash == record_hash(name, record.number, record.bytes);
  return record;
}

// Where in the bytes a whole record begins; their size where none does.
std::size_t find_record(std::span<const std::uint8_t> rest, std::uint64_t name) {
  ByteWriter mark;
  mark(kRecordMark);
  std::size_t at = 0;
  while (at + kRecordHeaderSize <= rest.size()) {
    const void* found =
        memmem(rest.data() + at, rest.size() - at, mark.bytes().data(), mark.bytes().size());
    if (!found) break;
    at = static_cast<std::size_t>(static_cast<const std::uint8_t*>(found) - rest.data());
    if (record_at(rest.subspan(at), name).whole) return at;
    ++at;
  }
  return rest.size();
}

RecordScan refuse(RecordScan scan, Reason reason, std::string detail) {
  scan.reason = reason;
  scan.detail = std::move(detail);
  return scan;
}

bool write_all(int descriptor, std::span<const std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::write(descriptor, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(n));
  }
  return true;
}

// A file's name in its folder is on the disk once the folder is.
bool flush_folder(const std::filesystem::path& file) {
  const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : ".";
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return false;
  const bool flushed = ::fsync(descriptor) == 0;
  ::close(descriptor);
  return flushed;
}

}  // namespace

std::vector<std::uint8_t> record_file(std::uint64_t name, std::span<const std::uint8_t> record) {
  ByteWriter out;
  for (const auto& part : {file_header(name), record_header(name, 0, record)})
    out.append(part.data(), part.size());
  out.append(record.data(), record.size());
  return out.bytes();
}

RecordScan scan_records(std::vector<std::uint8_t> bytes) {
  RecordScan scan;
  scan.bytes = std::move(bytes);
  const std::span<const std::uint8_t> all(scan.bytes);
  if (all.size() < kHeaderSize || std::memcmp(all.data(), kMark.data(), kMark.size()) != 0)
    return refuse(std::move(scan), Reason::kMapFileUnknown, "it does not begin as a map does");
  ByteReader in(all.subspan(kMark.size(), kHeaderSize - kMark.size()));
  std::uint32_t zero = 0;
  std::uint64_t hash = 0;
  in(scan.version), in(zero), in(scan.name), in(hash);
  if (hash != hash_bytes(all.first(kHeaderSize - sizeof hash), 0))
    return refuse(std::move(scan), Reason::kMapFileDamaged, "its first 32 bytes are damaged");
  if (scan.version > kFileVersion)
    return refuse(std::move(scan), Reason::kMapFileNewer,
                  "its version is " + std::to_string(scan.version) + ", known is up to " +
                      std::to_string(kFileVersion));
  scan.whole_bytes = kHeaderSize;
  while (scan.whole_bytes < all.size()) {
    const RecordAt record = record_at(all.subspan(scan.whole_bytes), scan.name);
    if (!record.whole || record.number != scan.records.size()) break;
    scan.records.push_back(record.bytes);
    scan.whole_bytes += kRecordHeaderSize + record.bytes.size();
  }
  scan.torn_bytes = all.size() - scan.whole_bytes;
  const std::span<const std::uint8_t> rest = all.subspan(scan.whole_bytes);
  const std::size_t next = find_record(rest, scan.name);
  if (next < rest.size())
    return refuse(std::move(scan), Reason::kMapFileDamaged,
                  "record " + std::to_string(scan.records.size()) + ", " + std::to_string(next) +
                      " bytes from byte " + std::to_string(scan.whole_bytes) +
                      " on, is damaged, and whole ones follow");
  if (scan.records.empty())
    return refuse(std::move(scan), Reason::kMapFileDamaged, "no record in it is whole");
  return scan;
}

RecordScan scan_records(const std::filesystem::path& file) {
  const int descriptor = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
  struct stat status {};
  if (descriptor < 0 || ::fstat(descriptor, &status) != 0 || !S_ISREG(status.st_mode)) {
    if (descriptor >= 0 && !S_ISREG(status.st_mode)) errno = EISDIR;
    RecordScan scan = refuse({}, Reason::kMapFileUnreadable, failure("cannot read", file));
    if (descriptor >= 0) ::close(descriptor);
    return scan;
  }
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(status.st_size));
  std::size_t read = 0;
  while (read < bytes.size()) {
    const ssize_t n = ::read(descriptor, bytes.data() + read, bytes.size() - read);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) break;
    read += static_cast<std::size_t>(n);
  }
  ::close(descriptor);
  bytes.resize(read);
  return scan_records(std::move(bytes));
}

std::string cut_to_whole(const std::filesystem::path& file, const RecordScan& scan) {
  if (scan.records.empty()) return "no record of " + file.string() + " is whole";
  const int descriptor = ::open(file.c_str(), O_WRONLY | O_CLOEXEC);
  if (descriptor < 0) return failure("cannot write", file);
  const bool cut = ::ftruncate(descriptor, static_cast<off_t>(scan.whole_bytes)) == 0 &&
                   ::fsync(descriptor) == 0;
  std::string problem = cut ? "" : failure("cannot cut", file);
  ::close(descriptor);
  return problem;
}

std::string RecordWriter::replace(const std::filesystem::path& file, std::uint64_t name,
                                  std::span<const std::uint8_t> first) {
  const std::filesystem::path beside = file.string() + ".new";
  const int descriptor =
      ::open(beside.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, S_IRUSR | S_IWUSR | S_IRGRP);
  if (descriptor < 0) return failure("cannot write", beside);
  const bool written = write_all(descriptor, file_header(name)) &&
                       write_all(descriptor, record_header(name, 0, first)) &&
                       write_all(descriptor, first) && ::fsync(descriptor) == 0 &&
                       ::rename(beside.c_str(), file.c_str()) == 0;
  if (!written) {
    std::string problem = failure("cannot write", beside);
    ::close(descriptor);
    ::unlink(beside.c_str());
    return problem;
  }
  close();
  descriptor_ = descriptor;
  name_ = name;
  number_ = 1;
  size_ = kHeaderSize + kRecordHeaderSize + first.size();
  if (flush_folder(file)) return "";
  std::string problem = failure("cannot flush the folder of", file);
  close();  // who knows which of the two will be there: the next call writes it once more
  return problem;
}

std::string RecordWriter::append(std::span<const std::uint8_t> record) {
  if (descriptor_ < 0) return "no map file is open";
  if (write_all(descriptor_, record_header(name_, number_, record)) &&
      write_all(descriptor_, record) && ::fdatasync(descriptor_) == 0) {
    ++number_;
    size_ += kRecordHeaderSize + record.size();
    return "";
  }
  std::string problem = std::string("cannot append to the map's file: ") + std::strerror(errno);
  // What is half there must not be in the way of the next one.
  const auto whole = static_cast<off_t>(size_);
  if (::ftruncate(descriptor_, whole) != 0 || ::lseek(descriptor_, whole, SEEK_SET) != whole)
    close();
  return problem;
}

void RecordWriter::close() {
  if (descriptor_ >= 0) ::close(descriptor_);
  descriptor_ = -1;
}

}  // namespace eifmap
