#include "recorder/control/second_copy.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <map>

#include "core/random.h"
#include "tests/support/temporary_folder.h"

namespace roseau::recorder {
namespace {

using namespace std::chrono_literals;
using roseau::testing::read_text_file;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr std::size_t kBlock = FileCopier::kBlockBytes;

std::string noise(std::size_t bytes, std::uint64_t seed = 1) {
  const RandomStream random(seed, 0);
  std::string text(bytes, '\0');
  for (std::size_t i = 0; i < bytes; ++i) text[i] = static_cast<char>(random.bits(i / 8) >> (8 * (i % 8)));
  return text;
}

/// A disk in memory that can be told to fail.
struct FaultyDisk : CopyDisk {
  struct Shared {
    std::mutex mutex;
    std::map<std::string, std::string> growing;
    std::map<std::string, std::string> finished;
    std::size_t capacity = std::numeric_limits<std::size_t>::max();
    bool gone = false;
    std::optional<std::size_t> bad_byte;  // comes back wrong
    int opened = 0;
  };
  struct File : CopyFile {
    File(Shared& on, std::string called) : disk(on), name(std::move(called)) {}
    Result<void> write(std::uint64_t offset, std::span<const std::byte> bytes) override {
      const std::scoped_lock lock(disk.mutex);
      if (disk.gone) return Error{ErrorCode::io, "cannot write " + name + ": no such device"};
      if (offset + bytes.size() > disk.capacity) return Error{ErrorCode::no_space, "cannot write " + name + ": it is full"};
      auto& file = disk.growing[name];
      file.resize(std::max<std::size_t>(file.size(), offset + bytes.size()));
      std::memcpy(file.data() + offset, bytes.data(), bytes.size());
      return {};
    }
    Result<void> sync() override { return {}; }
    Result<void> read_back(std::uint64_t offset, std::span<std::byte> to) override {
      const std::scoped_lock lock(disk.mutex);
      std::memcpy(to.data(), disk.growing.at(name).data() + offset, to.size());
      if (disk.bad_byte && *disk.bad_byte >= offset && *disk.bad_byte < offset + to.size())
        to[*disk.bad_byte - offset] ^= std::byte{1};
      return {};
    }
    Result<void> finish(std::uint64_t bytes) override {
      const std::scoped_lock lock(disk.mutex);
      auto file = disk.growing.extract(name);
      EXPECT_EQ(file.mapped().size(), bytes);
      disk.finished[name] = file.mapped();
      return {};
    }
    Shared& disk;
    std::string name;
  };
  explicit FaultyDisk(std::shared_ptr<Shared> it) : shared(std::move(it)) {}
  Result<std::unique_ptr<CopyFile>> create(const std::string& name) override {
    const std::scoped_lock lock(shared->mutex);
    if (shared->gone) return Error{ErrorCode::io, "cannot create " + name + ": no such device"};
    ++shared->opened;
    shared->growing[name].clear();
    return std::unique_ptr<CopyFile>(std::make_unique<File>(*shared, name));
  }
  void remember(const std::string& name) override {
    const std::scoped_lock lock(shared->mutex);
    shared->growing[name];
  }
  bool has(const std::string& name, std::uint64_t bytes) override {
    const std::scoped_lock lock(shared->mutex);
    return shared->finished.contains(name) && shared->finished.at(name).size() == bytes;
  }
  std::vector<std::string> unfinished() override {
    std::vector<std::string> names;
    for (const auto& [name, bytes] : shared->growing) names.push_back(name);
    return names;
  }
  std::shared_ptr<Shared> shared;
};

class SecondCopyTest : public ::testing::Test {
 protected:
  std::unique_ptr<SecondCopy> make(std::chrono::milliseconds retry = 1h) {
    return std::make_unique<SecondCopy>(std::make_unique<FaultyDisk>(disk), "/mnt/second", folder.path(), retry);
  }
  /// Through as many tries as it takes; gives up loudly.
  static void wait_until_done(SecondCopy& copy) {
    for (int i = 0; i < 10'000; ++i) {
      if (copy.finish(10ms)) return;
      std::this_thread::sleep_for(1ms);
    }
    FAIL() << "waited in vain";
  }
  const roseau::testing::TemporaryFolder folder;
  std::shared_ptr<FaultyDisk::Shared> disk = std::make_shared<FaultyDisk::Shared>();
};

TEST_F(SecondCopyTest, FollowsAFileThatGrowsBlockByBlock) {
  const std::string content = noise(3 * kBlock + 1000);
  FaultyDisk target(disk);
  FileCopier copier(folder.write("a.mcap", content), target);
  EXPECT_FALSE(*copier.step(kBlock - 1, false));
  EXPECT_EQ(copier.verified_bytes(), 0U);
  EXPECT_FALSE(*copier.step(2 * kBlock + 5, false));
  EXPECT_EQ(copier.verified_bytes(), 2 * kBlock);
  EXPECT_EQ(disk->growing.at("a.mcap"), content.substr(0, 2 * kBlock)) << "no byte that may still change";
  EXPECT_FALSE(*copier.step(content.size(), true));
  EXPECT_TRUE(copier.is_done());
  EXPECT_EQ(disk->finished.at("a.mcap"), content);
  EXPECT_THAT(disk->growing, IsEmpty());
}

TEST_F(SecondCopyTest, TakesABitAtATime) {
  const std::string content = noise((FileCopier::kBlocksPerCheck + 1) * kBlock);
  FaultyDisk target(disk);
  FileCopier copier(folder.write("a.mcap", content), target);
  EXPECT_TRUE(*copier.step(content.size(), true));
  EXPECT_EQ(copier.verified_bytes(), FileCopier::kBlocksPerCheck * kBlock);
  EXPECT_FALSE(*copier.step(content.size(), true));
  EXPECT_TRUE(copier.is_done());
}

TEST_F(SecondCopyTest, AByteThatComesBackWrongIsNoticedAndTheCopyBegunAnew) {
  const std::string content = noise(kBlock + 10);
  disk->bad_byte = kBlock + 3;
  FaultyDisk target(disk);
  FileCopier copier(folder.write("a.mcap", content), target);
  const auto stepped = copier.step(content.size(), true);
  ASSERT_FALSE(stepped);
  EXPECT_THAT(stepped.error().message, HasSubstr("other bytes"));
  EXPECT_THAT(disk->finished, IsEmpty());
  EXPECT_EQ(copier.verified_bytes(), 0U);
  disk->bad_byte.reset();
  ASSERT_TRUE(copier.step(content.size(), true));
  EXPECT_EQ(disk->finished.at("a.mcap"), content);
}

TEST_F(SecondCopyTest, CopiesFinishedFilesInOrder) {
  auto copy = make();
  const std::string first = noise(100, 1);
  const std::string second = noise(200'000, 2);
  copy->add_finished(folder.write("a.mcap", first));
  copy->add_finished(folder.write("b.mcap", second));
  EXPECT_TRUE(copy->finish(60s));
  EXPECT_EQ(disk->finished.at("a.mcap"), first);
  EXPECT_EQ(disk->finished.at("b.mcap"), second);
  EXPECT_EQ(copy->state().verified_bytes, 200'100U);
  EXPECT_EQ(copy->state().behind_bytes, 0U);
  EXPECT_EQ(copy->state().state, DeviceState::running);
  EXPECT_THAT(copy->unfinished(), IsEmpty());
}

TEST_F(SecondCopyTest, ADiskThatIsGoneIsSaidAndEverythingIsCopiedWhenItIsBack) {
  disk->gone = true;
  auto copy = make(1ms);
  const std::string content = noise(1000);
  const auto file = folder.write("a.mcap", content);
  copy->add_finished(file);
  EXPECT_FALSE(copy->finish(60s));
  EXPECT_EQ(copy->state().state, DeviceState::degraded);
  EXPECT_THAT(copy->state().message, HasSubstr("no such device"));
  EXPECT_EQ(copy->state().behind_bytes, 1000U);
  EXPECT_THAT(copy->unfinished(), ElementsAre(std::filesystem::path(file)));
  {
    const std::scoped_lock lock(disk->mutex);
    disk->gone = false;
  }
  wait_until_done(*copy);
  EXPECT_EQ(disk->finished.at("a.mcap"), content);
  EXPECT_EQ(copy->state().state, DeviceState::running);
  EXPECT_EQ(copy->state().message, "");
}

TEST_F(SecondCopyTest, AFullDiskIsSaid) {
  disk->capacity = 500;
  auto copy = make();
  copy->add_finished(folder.write("a.mcap", noise(1000)));
  EXPECT_FALSE(copy->finish(60s));
  EXPECT_THAT(copy->state().message, HasSubstr("it is full"));
}

TEST_F(SecondCopyTest, AFileThatWasDeletedIsForgotten) {
  disk->gone = true;
  auto copy = make(1ms);
  const auto file = folder.write("a.mcap", noise(1000));
  copy->add_finished(file);
  EXPECT_FALSE(copy->finish(60s));
  std::filesystem::remove(file);
  wait_until_done(*copy);
  EXPECT_THAT(copy->unfinished(), IsEmpty());
}

TEST_F(SecondCopyTest, WhatAnEarlierRunDidNotFinishIsTakenUpAgain) {
  const std::string content = noise(1000);
  folder.write("a.mcap", content);
  disk->growing["a.mcap"] = content.substr(0, 10);
  disk->growing["not here any more.mcap"];
  auto copy = make();
  EXPECT_TRUE(copy->finish(60s));
  EXPECT_EQ(disk->finished.at("a.mcap"), content);
}

TEST_F(SecondCopyTest, WhatAnEarlierRunMayHaveCopiedIsCopiedOnlyWhereItDidNot) {
  const std::string content = noise(1000);
  disk->finished["there.mcap"] = content;
  disk->finished["other.mcap"] = "shorter";
  auto copy = make();
  for (const char* name : {"there.mcap", "other.mcap", "missing.mcap"}) copy->add_unless_there(folder.write(name, content));
  EXPECT_TRUE(copy->finish(60s));
  EXPECT_EQ(disk->opened, 2);
  for (const char* name : {"there.mcap", "other.mcap", "missing.mcap"}) EXPECT_EQ(disk->finished.at(name), content) << name;
}

TEST_F(SecondCopyTest, OnARealDisk) {
  const roseau::testing::TemporaryFolder second;
  const auto directory = second.path() / "made";
  const std::string content = noise(2 * kBlock + 4097);
  const auto file = folder.write("a.mcap", content);
  {
    SecondCopy copy(make_copy_directory(directory), directory.string(), folder.path());
    copy.follow(file, kBlock);
    copy.add_finished(file);
    EXPECT_TRUE(copy.finish(60s));
  }
  EXPECT_EQ(read_text_file(directory / "a.mcap"), content);
  EXPECT_FALSE(std::filesystem::exists(directory / "a.mcap.copying"));
  EXPECT_TRUE(make_copy_directory(directory)->has("a.mcap", content.size()));
  EXPECT_FALSE(make_copy_directory(directory)->has("a.mcap", 1));
  EXPECT_FALSE(make_copy_directory(directory)->has("b.mcap", 0));
  make_copy_directory(directory)->remember("b.mcap");
  EXPECT_THAT(make_copy_directory(directory)->unfinished(), ElementsAre("b.mcap"));
}

TEST_F(SecondCopyTest, ReadsBackWhatIsOnTheDisk) {
  const roseau::testing::TemporaryFolder second;
  const auto disk_directory = make_copy_directory(second.path());
  auto file = disk_directory->create("a.mcap");
  ASSERT_TRUE(file);
  const std::string content = noise(10'001);
  ASSERT_TRUE((*file)->write(0, std::as_bytes(std::span(content))));
  ASSERT_TRUE((*file)->sync());
  std::string back(5'000, '\0');
  ASSERT_TRUE((*file)->read_back(5'001, std::as_writable_bytes(std::span(back))));
  EXPECT_EQ(back, content.substr(5'001));
  EXPECT_FALSE((*file)->read_back(9'000, std::as_writable_bytes(std::span(back)))) << "there is nothing there";
}

}  // namespace
}  // namespace roseau::recorder
