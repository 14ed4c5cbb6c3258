#include <gtest/gtest.h>

#include <memory>
#include <thread>

#include "core/spsc_ring.h"
#include "core/stream.h"

namespace roseau {
namespace {

TEST(SpscRing, FullRingLeavesTheItemWithTheCaller) {
  SpscRing<std::unique_ptr<int>> ring(2);
  auto first = std::make_unique<int>(1);
  auto second = std::make_unique<int>(2);
  auto third = std::make_unique<int>(3);
  EXPECT_TRUE(ring.try_push(first));
  EXPECT_TRUE(ring.try_push(second));
  EXPECT_FALSE(ring.try_push(third));
  ASSERT_NE(third, nullptr);
  EXPECT_EQ(**ring.try_pop(), 1);
  EXPECT_TRUE(ring.try_push(third));
  EXPECT_EQ(ring.size(), 2U);
}

TEST(SpscRing, KeepsOrderBetweenThreads) {
  SpscRing<int> ring(64);
  constexpr int kCount = 200000;
  std::jthread producer([&ring] {
    for (int i = 0; i < kCount;) {
      int item = i;
      if (ring.try_push(item)) ++i;
    }
  });
  for (int expected = 0; expected < kCount;) {
    const auto item = ring.try_pop();
    if (!item) continue;
    ASSERT_EQ(*item, expected++);
  }
}

TEST(StreamTable, TopicIsDescribedOnce) {
  StreamTable table;
  const auto id = table.add({.topic = "/sonic/raw", .kind = "raw_bytes", .device = "sonic", .metadata = {{"model", "x"}}});
  EXPECT_EQ(table.add({.topic = "/sonic/raw", .kind = "other"}), id);
  EXPECT_EQ(table.info(id).metadata.at("model"), "x");
  EXPECT_EQ(table.find("/sonic/raw"), id);
  EXPECT_FALSE(table.find("/sonic"));
}

}  // namespace
}  // namespace roseau
