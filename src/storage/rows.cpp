#include "storage/rows.h"

#include <algorithm>

#include "storage/hash.h"

namespace eifmap {
namespace {

constexpr std::uint32_t kErased = 0xffffffff;
constexpr std::size_t kDigestSize = 8;

// Never 0.
std::uint64_t hash_of(RowKey key, RowBytes row) {
  return hash_bytes(row, key.packed()) | 1;
}

}  // namespace

void RowBook::put(RowKey key, RowBytes row) {
  const std::uint64_t hash = hash_of(key, row);
  const auto known = hashes_.find(key.packed());
  if (known != hashes_.end() && known->second == hash) return;
  rows_(key.table);
  rows_(key.number);
  rows_.size(row.size());
  rows_.append(row.data(), row.size());
  changes_.push_back({key, hash});
}

void RowBook::erase(RowKey key) {
  if (!hashes_.contains(key.packed())) return;
  rows_(key.table);
  rows_(key.number);
  rows_(kErased);
  changes_.push_back({key, 0});
}

std::vector<std::uint8_t> RowBook::record() const {
  std::uint64_t digest = digest_;
  for (const Change& change : changes_) {
    const auto known = hashes_.find(change.key.packed());
    if (known != hashes_.end()) digest -= known->second;
    digest += change.hash;
  }
  ByteWriter out;
  out.reserve(kDigestSize + rows_.bytes().size());
  out(digest);
  out.append(rows_.bytes().data(), rows_.bytes().size());
  return out.take();
}

void RowBook::keep() {
  for (const Change& change : changes_) {
    std::uint64_t& hash = hashes_[change.key.packed()];
    digest_ += change.hash - hash;
    hash = change.hash;
    if (hash == 0) hashes_.erase(change.key.packed());
  }
  drop();
}

// After a record of the whole map come small ones: what it took is not held for them.
void RowBook::drop() {
  changes_ = {};
  rows_ = {};
}

std::string RowSet::add(RowBytes record) {
  if (record.size() < kDigestSize) return "a record is too short";
  ByteReader digest(record.first(kDigestSize));
  digest(digest_);
  RowBytes rest = record.subspan(kDigestSize);
  constexpr std::size_t kRowHeader = 9;
  while (!rest.empty()) {
    if (rest.size() < kRowHeader) return "a row is cut off";
    ByteReader in(rest.first(kRowHeader));
    RowKey key;
    std::uint32_t size = 0;
    in(key.table), in(key.number), in(size);
    rest = rest.subspan(kRowHeader);
    if (size == kErased) {
      rows_.erase(key.packed());
      continue;
    }
    if (size > rest.size()) return "a row is cut off";
    rows_[key.packed()] = rest.first(size);
    rest = rest.subspan(size);
  }
  return "";
}

std::string RowSet::problem() const {
  std::uint64_t digest = 0;
  for (const auto& [packed, row] : rows_)
    digest += hash_of({static_cast<Table>(packed >> 32), static_cast<std::uint32_t>(packed)}, row);
  return digest == digest_ ? "" : "its rows are not those that were written";
}

std::vector<std::uint32_t> RowSet::numbers(Table table) const {
  std::vector<std::uint32_t> numbers;
  for (const auto& [packed, row] : rows_)
    if (static_cast<Table>(packed >> 32) == table)
      numbers.push_back(static_cast<std::uint32_t>(packed));
  std::sort(numbers.begin(), numbers.end());
  return numbers;
}

RowBytes RowSet::operator[](RowKey key) const {
  const auto row = rows_.find(key.packed());
  return row == rows_.end() ? RowBytes() : row->second;
}

}  // namespace eifmap
