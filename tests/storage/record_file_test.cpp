// Files of records: what is written is read, and what is cut or changed is found.
#include "storage/record_file.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>

#include "sequence/temporary_folder.h"
#include "support/file_bytes.h"
#include "support/random.h"

namespace eifmap::test {
namespace {

using Record = std::vector<std::uint8_t>;

Record record_of(std::uint64_t seed) {
  Random random(seed);
  Record record(20 + random.bits() % 60);
  for (std::uint8_t& byte : record) byte = static_cast<std::uint8_t>(random.bits());
  return record;
}

constexpr int kRecords = 5;

std::filesystem::path write(const TemporaryFolder& folder) {
  RecordWriter writer;
  const std::filesystem::path file = folder.path() / "records";
  EXPECT_EQ(writer.replace(file, 77, record_of(0)), "");
  for (int r = 1; r < kRecords; ++r) EXPECT_EQ(writer.append(record_of(r)), "");
  EXPECT_EQ(writer.size(), std::filesystem::file_size(file));
  return file;
}

// How many of the records that were written are read; -1 where what is read is another.
int prefix(const RecordScan& scan) {
  for (std::size_t r = 0; r < scan.records.size(); ++r)
    if (Record(scan.records[r].begin(), scan.records[r].end()) != record_of(r)) return -1;
  return static_cast<int>(scan.records.size());
}

TEST(RecordFile, GivesBackWhatWasWritten) {
  const TemporaryFolder folder;
  const RecordScan scan = scan_records(write(folder));
  ASSERT_TRUE(scan.ok()) << scan.detail;
  EXPECT_EQ(prefix(scan), kRecords);
  EXPECT_EQ(scan.torn_bytes, 0u);
  EXPECT_EQ(scan.version, kFileVersion);
}

TEST(RecordFile, CutAnywhereItEndsWithTheLastWholeRecord) {
  const TemporaryFolder folder;
  const Record all = read_bytes(write(folder));
  int most = 0;
  for (std::size_t size = 0; size <= all.size(); ++size) {
    const RecordScan scan =
        scan_records(Record(all.begin(), all.begin() + static_cast<long>(size)));
    const int whole = prefix(scan);
    ASSERT_GE(whole, most) << "at " << size;
    most = whole;
    ASSERT_EQ(scan.ok(), whole > 0) << "at " << size;
    ASSERT_EQ(scan.whole_bytes + scan.torn_bytes,
              scan.ok() ? size : scan.whole_bytes + scan.torn_bytes);
  }
  EXPECT_EQ(most, kRecords);
}

// In the last record it is as if torn; before it, whole ones follow, and that is damage.
TEST(RecordFile, AChangedBitIsFound) {
  const TemporaryFolder folder;
  const Record all = read_bytes(write(folder));
  const std::size_t last = all.size() - 32 - record_of(kRecords - 1).size();
  for (std::size_t bit = 0; bit < 8 * all.size(); ++bit) {
    Record changed = all;
    changed[bit / 8] ^= static_cast<std::uint8_t>(1u << bit % 8);
    const RecordScan scan = scan_records(std::move(changed));
    ASSERT_GE(prefix(scan), 0) << "bit " << bit;
    ASSERT_LT(prefix(scan), kRecords) << "bit " << bit;
    ASSERT_EQ(scan.ok(), bit / 8 >= last) << "bit " << bit << ": " << scan.detail;
  }
}

TEST(RecordFile, ARecordOfAnotherFileIsNone) {
  const TemporaryFolder folder;
  const Record all = read_bytes(write(folder));
  RecordWriter writer;
  const std::filesystem::path other = folder.path() / "other";
  ASSERT_EQ(writer.replace(other, 78, record_of(0)), "");
  Record mixed = read_bytes(other);
  mixed.insert(mixed.end(), all.begin() + static_cast<long>(mixed.size()), all.end());
  const RecordScan scan = scan_records(std::move(mixed));
  EXPECT_TRUE(scan.ok());
  EXPECT_EQ(prefix(scan), 1);
}

TEST(RecordFile, SaysWhyItIsNone) {
  const TemporaryFolder folder;
  EXPECT_EQ(scan_records(folder.path() / "nothing").reason, Reason::kMapFileUnreadable);
  EXPECT_EQ(scan_records(folder.path()).reason, Reason::kMapFileUnreadable);
  EXPECT_EQ(scan_records(Record(100, 'x')).reason, Reason::kMapFileUnknown);
  EXPECT_EQ(scan_records(Record{}).reason, Reason::kMapFileUnknown);
}

TEST(RecordFile, IsCutToWhatIsWhole) {
  const TemporaryFolder folder;
  const std::filesystem::path file = write(folder);
  Record all = read_bytes(file);
  all.resize(all.size() - 3);
  write_bytes(file, all);
  const RecordScan torn = scan_records(file);
  EXPECT_GT(torn.torn_bytes, 0u);
  ASSERT_EQ(cut_to_whole(file, torn), "");
  const RecordScan scan = scan_records(file);
  EXPECT_TRUE(scan.ok());
  EXPECT_EQ(scan.torn_bytes, 0u);
  EXPECT_EQ(prefix(scan), kRecords - 1);
}

// A disk that is full in the middle of a record, as a limit of the file's size.
TEST(RecordFile, ARecordThatDoesNotFitLeavesTheFileAsItWas) {
  const TemporaryFolder folder;
  RecordWriter writer;
  const std::filesystem::path file = folder.path() / "records";
  ASSERT_EQ(writer.replace(file, 77, record_of(0)), "");
  const Record before = read_bytes(file);
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit old{};
  getrlimit(RLIMIT_FSIZE, &old);
  const rlimit full{before.size() + 40, old.rlim_max};
  setrlimit(RLIMIT_FSIZE, &full);
  const std::string problem = writer.append(record_of(1));
  RecordWriter other;
  const std::string problem_of_new = other.replace(file, 78, Record(4000));
  setrlimit(RLIMIT_FSIZE, &old);
  EXPECT_NE(problem, "");
  EXPECT_NE(problem_of_new, "");
  EXPECT_EQ(read_bytes(file), before);
  EXPECT_EQ(writer.append(record_of(1)), "");
  EXPECT_EQ(prefix(scan_records(file)), 2);
}

}  // namespace
}  // namespace eifmap::test
