#include "core/frame.h"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

namespace roseau {
namespace {

TEST(FramePool, HandsOutEveryBufferOnceAndThenNothing) {
  FramePool pool(3, 16);
  std::vector<FrameLease> leases;
  for (int i = 0; i < 3; ++i) {
    leases.push_back(pool.acquire());
    ASSERT_TRUE(leases.back());
  }
  EXPECT_FALSE(pool.acquire());
  leases.pop_back();
  EXPECT_TRUE(pool.acquire());
}

TEST(FramePool, BufferReturnsOnlyWithTheLastLease) {
  FramePool pool(1, 16);
  FrameLease first = pool.acquire();
  FrameLease second = first;
  first = FrameLease{};
  EXPECT_EQ(pool.free_count(), 0U);
  second = FrameLease{};
  EXPECT_EQ(pool.free_count(), 1U);
}

TEST(FrameLease, OfAnotherOwnersMemoryLetsItGoWithTheLastLease) {
  std::vector<std::byte> memory(8, std::byte{7});
  auto owner = std::make_shared<int>(0);
  const std::weak_ptr<int> is_alive = owner;
  FrameLease first = FrameLease::of(memory, std::move(owner));
  first.writable_bytes()[1] = std::byte{9};
  FrameLease second = first;
  first = FrameLease{};
  EXPECT_FALSE(is_alive.expired());
  EXPECT_EQ(second.bytes().data(), memory.data());
  EXPECT_EQ(second.bytes().size(), 8U);
  EXPECT_EQ(second.bytes()[1], std::byte{9});
  second = FrameLease{};
  EXPECT_TRUE(is_alive.expired());
}

TEST(FramePool, LeaseOutlivesPool) {
  FrameLease lease;
  {
    FramePool pool(2, 16);
    lease = pool.acquire();
    lease.writable_bytes()[0] = std::byte{42};
  }
  EXPECT_EQ(lease.bytes()[0], std::byte{42});
}

TEST(FramePool, SixtyFourBuffersAreAllowed) {
  FramePool pool(64, 8);
  EXPECT_EQ(pool.free_count(), 64U);
}

TEST(FramePool, ConcurrentReleaseLosesNoBuffer) {
  FramePool pool(8, 8);
  std::vector<std::jthread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&pool] {
      for (int i = 0; i < 5000; ++i) {
        FrameLease lease = pool.acquire();
        FrameLease copy = lease;
        lease = FrameLease{};
      }
    });
  }
  threads.clear();
  EXPECT_EQ(pool.free_count(), 8U);
}

TEST(FramePoolDeathTest, WritingASharedBufferIsABug) {
  FramePool pool(1, 8);
  FrameLease lease = pool.acquire();
  const FrameLease shared = lease;
  EXPECT_DEATH(lease.writable_bytes(), "CHECK failed");
}

TEST(PixelFormat, NamesGoBothWays) {
  for (const auto format : {PixelFormat::mono8, PixelFormat::mono16, PixelFormat::bgr8, PixelFormat::rgb8}) {
    const auto back = pixel_format_from_string(to_string(format));
    ASSERT_TRUE(back);
    EXPECT_EQ(*back, format);
  }
  EXPECT_FALSE(pixel_format_from_string("mono9"));
}

TEST(ImageStorage, NamesGoBothWays) {
  for (const auto storage : {ImageStorage::raw, ImageStorage::png, ImageStorage::jpeg}) {
    const auto back = image_storage_from_string(to_string(storage));
    ASSERT_TRUE(back);
    EXPECT_EQ(*back, storage);
  }
  EXPECT_FALSE(image_storage_from_string("gif"));
}

TEST(CodedImage, IsTheUsedPartOfItsBuffer) {
  FramePool pool(1, 8);
  Frame frame;
  EXPECT_FALSE(frame.coded);
  frame.coded = {.lease = pool.acquire(), .size = 5, .format = ImageStorage::jpeg};
  EXPECT_TRUE(frame.coded);
  EXPECT_EQ(frame.coded.bytes().size(), 5U);
  frame = {};
  EXPECT_EQ(pool.free_count(), 1U);
}

}  // namespace
}  // namespace roseau
