#include "display/outbox.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace roseau::display {
namespace {

OutMessage message(const std::string& text) { return {.is_text = true, .head = text, .payload = nullptr}; }

std::vector<std::string> drain(Outbox& outbox) {
  std::vector<std::string> heads;
  while (auto next = outbox.next()) heads.push_back(next->head);
  return heads;
}

TEST(Outbox, KeepsSmallMessagesInOrderAndAll) {
  Outbox outbox(1000);
  for (const char* text : {"a", "b", "c"}) ASSERT_TRUE(outbox.push(message(text)));
  EXPECT_THAT(drain(outbox), testing::ElementsAre("a", "b", "c"));
  EXPECT_EQ(outbox.waiting_bytes(), 0U);
}

TEST(Outbox, KeepsOnlyTheNewestPictureOfEachSlotAndCountsTheRest) {
  Outbox outbox(1000);
  outbox.put_latest(1, message("first"));
  outbox.put_latest(2, message("other"));
  outbox.put_latest(1, message("second"));
  outbox.put_latest(1, message("third"));
  EXPECT_EQ(outbox.dropped_images(), 2U);
  EXPECT_THAT(drain(outbox), testing::ElementsAre("third", "other"));
}

TEST(Outbox, SendsSmallMessagesBeforePictures) {
  Outbox outbox(1000);
  outbox.put_latest(1, message("picture"));
  ASSERT_TRUE(outbox.push(message("small")));
  EXPECT_THAT(drain(outbox), testing::ElementsAre("small", "picture"));
}

TEST(Outbox, TakesPictureSlotsInTurn) {
  Outbox outbox(1000);
  std::vector<std::string> sent;
  for (int round = 0; round < 4; ++round) {
    // Both cameras are always faster than the client.
    outbox.put_latest(7, message("left"));
    outbox.put_latest(9, message("right"));
    sent.push_back(outbox.next()->head);
  }
  EXPECT_THAT(sent, testing::ElementsAre("left", "right", "left", "right"));
}

TEST(Outbox, RefusesSmallMessagesBeyondItsBudgetWithPayloadCounted) {
  Outbox outbox(10);
  const auto payload = std::make_shared<const std::vector<std::byte>>(8);
  ASSERT_TRUE(outbox.push({.is_text = false, .head = "h", .payload = payload}));
  EXPECT_EQ(outbox.waiting_bytes(), 9U);
  EXPECT_FALSE(outbox.push(message("ab")));
  EXPECT_TRUE(outbox.push(message("a")));
  ASSERT_TRUE(outbox.next());
  EXPECT_TRUE(outbox.push(message("abcdefgh")));
}

TEST(Outbox, ForgetsARemovedSlot) {
  Outbox outbox(10);
  outbox.put_latest(1, message("picture"));
  outbox.remove_slot(1);
  EXPECT_FALSE(outbox.next());
}

}  // namespace
}  // namespace roseau::display
