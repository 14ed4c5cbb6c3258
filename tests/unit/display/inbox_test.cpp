#include "display/inbox.h"

#include <gtest/gtest.h>

#include <thread>

namespace roseau::display {
namespace {

using namespace std::chrono_literals;

InboxItem small(StreamId stream, std::uint32_t sequence) {
  Sample sample;
  sample.header = {.stream = stream, .sequence = sequence};
  sample.payload = WindSample{};
  return {std::move(sample), HostTime{}};
}

InboxItem picture(StreamId stream, std::uint32_t sequence, FramePool& pool) {
  InboxItem item = small(stream, sequence);
  item.sample.payload = Frame{.pixels = pool.acquire(), .width = 1, .height = 1, .stride = 1};
  return item;
}

TEST(Inbox, KeepsSmallMessagesInOrder) {
  Inbox inbox(10);
  for (std::uint32_t i = 0; i < 5; ++i) ASSERT_TRUE(inbox.push(small(3, i)));
  for (std::uint32_t i = 0; i < 5; ++i) EXPECT_EQ(inbox.pop(0ms)->sample.header.sequence, i);
  EXPECT_FALSE(inbox.pop(0ms));
  EXPECT_TRUE(inbox.dropped().empty());
}

TEST(Inbox, DropsTheNewestSmallMessageWhenFullAndCountsIt) {
  Inbox inbox(2);
  ASSERT_TRUE(inbox.push(small(3, 0)));
  ASSERT_TRUE(inbox.push(small(3, 1)));
  EXPECT_FALSE(inbox.push(small(3, 2)));
  EXPECT_EQ(inbox.dropped().at(3), 1U);
  EXPECT_EQ(inbox.pop(0ms)->sample.header.sequence, 0U);
}

TEST(Inbox, KeepsTheNewestPictureOfEachCameraAndGivesTheOthersBack) {
  FramePool pool(4, 16);
  Inbox inbox(0);
  for (std::uint32_t i = 0; i < 10; ++i) {
    ASSERT_TRUE(inbox.push(picture(1, i, pool)));
    ASSERT_TRUE(inbox.push(picture(2, i, pool)));
  }
  EXPECT_EQ(pool.free_count(), 2U);
  EXPECT_EQ(inbox.dropped().at(1), 9U);
  const auto first = inbox.pop(0ms);
  const auto second = inbox.pop(0ms);
  EXPECT_EQ(first->sample.header.sequence, 9U);
  EXPECT_NE(first->sample.header.stream, second->sample.header.stream);
  EXPECT_FALSE(inbox.pop(0ms));
}

TEST(Inbox, WakesItsConsumer) {
  Inbox inbox(10);
  std::thread producer([&] { EXPECT_TRUE(inbox.push(small(1, 7))); });
  const auto item = inbox.pop(10s);
  producer.join();
  ASSERT_TRUE(item);
  EXPECT_EQ(item->sample.header.sequence, 7U);
}

TEST(Inbox, TakesFromManyProducersWithoutLoss) {
  constexpr std::uint32_t kEach = 2000;
  Inbox inbox(4 * kEach);
  std::vector<std::thread> producers;
  for (StreamId stream = 0; stream < 4; ++stream) {
    producers.emplace_back([&inbox, stream] {
      for (std::uint32_t i = 0; i < kEach; ++i) EXPECT_TRUE(inbox.push(small(stream, i)));
    });
  }
  std::array<std::uint32_t, 4> next{};
  for (std::uint32_t i = 0; i < 4 * kEach; ++i) {
    const auto item = inbox.pop(10s);
    ASSERT_TRUE(item);
    EXPECT_EQ(item->sample.header.sequence, next.at(item->sample.header.stream)++);
  }
  for (std::thread& producer : producers) producer.join();
}

}  // namespace
}  // namespace roseau::display
