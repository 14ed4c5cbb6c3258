#include "recorder/format/file_io.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <random>

#include "recorder/format/indexed_reader.h"
#include "recorder/format/writer.h"

namespace roseau::mcap {
namespace {

using ::testing::HasSubstr;

class FileIo : public ::testing::Test {
 protected:
  std::filesystem::path directory =
      std::filesystem::temp_directory_path() /
      ("roseau-file-io-" + std::to_string(::getpid()) + ::testing::UnitTest::GetInstance()->current_test_info()->name());
  void SetUp() override { std::filesystem::create_directories(directory); }
  void TearDown() override { std::filesystem::remove_all(directory); }

  static std::vector<std::byte> bytes(std::size_t size) { return std::vector<std::byte>(size, std::byte{42}); }
};

TEST_F(FileIo, ManyPartsOfEverySizeArriveInOrder) {
  auto file = FileWritable::create(directory / "a");
  ASSERT_TRUE(file);
  std::vector<std::byte> expected;
  std::vector<std::vector<std::byte>> pieces;
  for (std::size_t i = 0; i < 1000; ++i) pieces.emplace_back(i % 7 == 0 ? 0 : i, static_cast<std::byte>(i));
  std::vector<std::span<const std::byte>> parts(pieces.begin(), pieces.end());
  for (const auto& piece : pieces) expected.insert(expected.end(), piece.begin(), piece.end());
  ASSERT_TRUE((*file)->append(parts));
  ASSERT_TRUE((*file)->sync());
  ASSERT_TRUE((*file)->close());
  auto readable = FileReadable::open(directory / "a");
  ASSERT_TRUE(readable);
  std::vector<std::byte> read((*readable)->size());
  ASSERT_TRUE((*readable)->read(0, read));
  EXPECT_EQ(read, expected);
}

/// Appends of every size, small ones (page cache) and large ones (direct) mixed, in pieces.
void append_and_compare(const std::filesystem::path& path) {
  auto file = FileWritable::create(path);
  ASSERT_TRUE(file);
  std::mt19937 random(5);
  std::vector<std::byte> expected;
  for (int i = 0; i < 60; ++i) {
    const std::size_t size = random() % 3 == 0 ? random() % 2'500'000 : random() % 9'000;
    std::vector<std::byte> data(size);
    for (std::byte& byte : data) byte = static_cast<std::byte>(random());
    const std::span<const std::byte> all(data);
    const std::size_t at = size == 0 ? 0 : random() % size;
    const std::span<const std::byte> parts[] = {all.first(at), {}, all.subspan(at)};
    ASSERT_TRUE((*file)->append(parts));
    expected.insert(expected.end(), data.begin(), data.end());
    ASSERT_LE(std::filesystem::file_size(path), expected.size());  // a crash leaves no padding
    ASSERT_TRUE(i % 4 != 0 || (*file)->flush());
    ASSERT_TRUE(i % 10 != 0 || (*file)->begin_sync());
    if (i % 15 == 0) {
      ASSERT_TRUE((*file)->sync());
      ASSERT_EQ(std::filesystem::file_size(path), expected.size());
      ASSERT_EQ((*file)->written(), expected.size());
    }
  }
  ASSERT_TRUE((*file)->close());
  auto readable = FileReadable::open(path);
  ASSERT_TRUE(readable);
  std::vector<std::byte> read((*readable)->size());
  ASSERT_TRUE((*readable)->read(0, read));
  EXPECT_TRUE(read == expected);
}

TEST_F(FileIo, SmallAndLargeAppendsMakeOneStream) { append_and_compare(directory / "a"); }

TEST_F(FileIo, AFileSystemWithoutDirectWritingWillDo) {
  const std::filesystem::path memory = "/dev/shm";  // tmpfs: older kernels have no O_DIRECT there
  if (!std::filesystem::is_directory(memory)) GTEST_SKIP() << "no /dev/shm here";
  const auto path = memory / directory.filename();
  append_and_compare(path);
  std::filesystem::remove(path);
}

TEST_F(FileIo, ReservedSpaceIsGivenBackAndNeverSeenInTheSize) {
  auto file = FileWritable::create(directory / "a");
  ASSERT_TRUE(file);
  const auto data = bytes(1000);
  const std::span<const std::byte> parts[] = {data};
  ASSERT_TRUE((*file)->append(parts));
  ASSERT_TRUE((*file)->sync());
  EXPECT_EQ(std::filesystem::file_size(directory / "a"), 1000U);  // also what a crash leaves
  ASSERT_TRUE((*file)->close());
  struct stat status {};
  ASSERT_EQ(::stat((directory / "a").c_str(), &status), 0);
  EXPECT_EQ(status.st_size, 1000);
  EXPECT_LT(status.st_blocks * 512, 1 << 20);
}

TEST_F(FileIo, AnExistingFileIsNeverOverwritten) {
  std::ofstream(directory / "a") << "precious";
  const auto file = FileWritable::create(directory / "a");
  ASSERT_FALSE(file);
  EXPECT_THAT(file.error().message, HasSubstr("never overwritten"));
  EXPECT_EQ(std::filesystem::file_size(directory / "a"), 8U);
}

TEST_F(FileIo, MissingDirectoryAndMissingFileAreNamed) {
  EXPECT_EQ(FileWritable::create(directory / "no" / "a").error().code, ErrorCode::not_found);
  const auto missing = FileReadable::open(directory / "missing.mcap");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::not_found);
  EXPECT_THAT(missing.error().message, HasSubstr("missing.mcap"));
  EXPECT_THAT(FileReadable::open(directory).error().message, HasSubstr("is a directory"));
}

TEST_F(FileIo, AFullDiskIsAnErrorAtOnce) {
  const int fd = ::open("/dev/full", O_WRONLY);
  ASSERT_GE(fd, 0);
  const auto file = FileWritable::adopt(fd, "/dev/full");
  const auto data = bytes(10);
  const std::span<const std::byte> parts[] = {data};
  const auto written = file->append(parts);
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, ErrorCode::no_space);
  EXPECT_THAT(written.error().message, HasSubstr("/dev/full"));
  EXPECT_THAT(written.error().message, HasSubstr("free some space"));
}

/// Files of this process may not grow beyond `bytes` while this lives: a disk that takes a part of a write and no more.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) {
    ::signal(SIGXFSZ, SIG_IGN);
    ::getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() { ::setrlimit(RLIMIT_FSIZE, &before_); }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  rlimit before_{};
};

TEST_F(FileIo, APlainWriteThatFailsInTheMiddleIsTakenBack) {
  const auto file = FileWritable::adopt(::open((directory / "a").c_str(), O_WRONLY | O_CREAT, 0644), "a");
  const auto large = bytes(3000);
  const auto small = bytes(1000);
  const std::span<const std::byte> large_parts[] = {large, large};
  const std::span<const std::byte> small_parts[] = {small};
  {
    const FileSizeLimit limit(10'000);
    ASSERT_TRUE(file->append(large_parts));
    EXPECT_FALSE(file->append(large_parts));
    EXPECT_EQ(std::filesystem::file_size(directory / "a"), 6000U);
    EXPECT_TRUE(file->append(small_parts));  // what fits may still be written: the summary
  }
  ASSERT_TRUE(file->close());
  EXPECT_EQ(std::filesystem::file_size(directory / "a"), 7000U);
}

TEST_F(FileIo, AWriteThatFailsLaterStaysFailedAndSaysHowFarItCame) {
  auto file = FileWritable::create(directory / "a");
  ASSERT_TRUE(file);
  std::vector<std::byte> large(3'000'001);
  std::mt19937 random(6);
  for (std::byte& byte : large) byte = static_cast<std::byte>(random());
  const std::span<const std::byte> parts[] = {large};
  {
    const FileSizeLimit limit(20'000'000);
    ASSERT_TRUE((*file)->append(parts));
    ASSERT_TRUE((*file)->sync());
    EXPECT_EQ((*file)->written(), 3'000'001U);
    Result<void> appended;
    for (int i = 0; i < 40 && appended; ++i) appended = (*file)->append(parts);  // seven go into the file
    ASSERT_FALSE(appended);
    EXPECT_THAT(appended.error().message, HasSubstr("takes no larger files"));
  }
  EXPECT_FALSE((*file)->append(parts)) << "there is room again, but a hole before it";
  EXPECT_FALSE((*file)->sync());
  const std::uint64_t written = (*file)->written();
  EXPECT_GE(written, 3'000'001U);
  EXPECT_LE(written, 20'000'000U);
  EXPECT_FALSE((*file)->close());
  auto readable = FileReadable::open(directory / "a");
  ASSERT_TRUE(readable);
  ASSERT_GE((*readable)->size(), written);
  std::vector<std::byte> read(written);
  ASSERT_TRUE((*readable)->read(0, read));
  for (std::size_t i = 0; i < read.size(); ++i) ASSERT_EQ(read[i], large[i % large.size()]) << i;
}

TEST_F(FileIo, AWriterOnAFullDiskSaysSo) {
  const auto file = FileWritable::adopt(::open("/dev/full", O_WRONLY), "/dev/full");
  Writer writer(*file);
  EXPECT_EQ(writer.begin({}).error().code, ErrorCode::no_space);
}

TEST_F(FileIo, OpenErrorNamesTheFile) {
  std::ofstream(directory / "a.mcap") << "this is no session";
  const auto reader = IndexedReader::open(directory / "a.mcap");
  ASSERT_FALSE(reader);
  EXPECT_THAT(reader.error().message, HasSubstr("a.mcap is not an MCAP file"));
}

}  // namespace
}  // namespace roseau::mcap
