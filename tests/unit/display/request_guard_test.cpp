#include "display/request_guard.h"

#include <gtest/gtest.h>

namespace roseau::display {
namespace {

TEST(RequestGuard, ServesAddressesLocalhostAndItsOwnName) {
  for (const char* host : {"127.0.0.1:8420", "127.0.0.1", "[::1]:8420", "192.168.1.20:8420", "localhost:8420", "LOCALHOST",
                           "field-laptop:8420", "Field-Laptop.local:8420"}) {
    EXPECT_TRUE(host_allowed(host, "field-laptop")) << host;
  }
}

TEST(RequestGuard, DoesNotServeForeignNames) {
  // A name server of somebody else's may point any of these here.
  for (const char* host :
       {"evil.example:8420", "127.0.0.1.evil.example", "localhost.evil.example", "", "[::1", "field-laptop.evil"}) {
    EXPECT_FALSE(host_allowed(host, "field-laptop")) << host;
  }
  EXPECT_FALSE(host_allowed("", ""));
}

TEST(RequestGuard, TakesActionsFromTheSameOriginAndLoopback) {
  const std::string host = "192.168.1.20:8420";
  EXPECT_TRUE(origin_may_act("", host));
  EXPECT_TRUE(origin_may_act("http://192.168.1.20:8420", host));
  EXPECT_TRUE(origin_may_act("http://localhost:3000", host));
  EXPECT_TRUE(origin_may_act("http://127.0.0.1:5173", host));
  for (const char* origin : {"https://evil.example", "http://evil.example", "http://192.168.1.20:9000", "null", "file://",
                             "http://127.0.0.1.evil.example", "http://localhost.evil.example", "http://1270.0.0.1"}) {
    EXPECT_FALSE(origin_may_act(origin, host)) << origin;
  }
}

TEST(RequestGuard, LetsViewersWatchThatMayNotAct) {
  const std::vector<std::string> viewers = {"https://app.foxglove.dev"};
  EXPECT_TRUE(origin_may_watch("https://app.foxglove.dev", "127.0.0.1:8420", viewers));
  EXPECT_TRUE(origin_may_watch("file://", "127.0.0.1:8420", viewers));
  EXPECT_TRUE(origin_may_watch("http://127.0.0.1:8420", "127.0.0.1:8420", viewers));
  EXPECT_FALSE(origin_may_watch("https://app.foxglove.dev.evil.example", "127.0.0.1:8420", viewers));
  EXPECT_FALSE(origin_may_watch("https://evil.example", "127.0.0.1:8420", viewers));
}

}  // namespace
}  // namespace roseau::display
