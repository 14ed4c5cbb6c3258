#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "render_support.h"
#include "synthesis/render/led_schedule.h"

namespace roseau::render {
namespace {

using namespace render::testing;  // NOLINT(google-build-using-namespace)

constexpr std::array<std::array<const char*, 18>, 4> kLayout{
    {{"F", "A0", "A1", "A2", "A3", "A4", "A5", "A6", "A7", "A8", "A9", "A10", "A11", "A12", "A13", "A14", "A15", "F"},
     {"F", "B0", "B1", "B2", "B3", "B4", "B5", "B6", "B7", "B8", "B9", "B10", "B11", "B12", "B13", "B14", "B15", "D"},
     {"F", "G9", "G8", "G7", "G6", "G5", "G4", "G3", "G2", "G1", "G0", "P", "I3", "I2", "I1", "I0", "S", "-"},
     {"F", "/G9", "/G8", "/G7", "/G6", "/G5", "/G4", "/G3", "/G2", "/G1", "/G0", "/P", "/I3", "/I2", "/I1", "/I0", "/S", "F"}}};

// The board's rules, tick by tick, told apart from the closed form by going through the counter's bits.
bool lit(const LedBoard& board, std::string led, std::uint64_t tick) {
  if (led[0] == '/') return !lit(board, led.substr(1), tick);
  const unsigned number = led.size() > 1 ? static_cast<unsigned>(std::stoi(led.substr(1))) : 0;
  const std::uint64_t step = (tick / 256) % 1024;
  const std::uint64_t gray = step ^ (step >> 1U);
  switch (led[0]) {
    case 'F':
      return true;
    case 'A':
      return tick % 16 == number;
    case 'B':
      return (tick / 16) % 16 == number;
    case 'G':
      return ((gray >> number) & 1U) != 0;
    case 'P':
      return std::popcount(gray) % 2 == 1;
    case 'I':
      return ((board.board_id >> number) & 1U) != 0;
    case 'S':
      return board.synchronised;
    default:
      return false;
  }
}

double share_by_ticks(const LedBoard& board, const std::string& led, double begin, double end) {
  double sum = 0;
  for (auto tick = static_cast<std::uint64_t>(begin); static_cast<double>(tick) < end; ++tick) {
    const double overlap = std::min(end, static_cast<double>(tick + 1)) - std::max(begin, static_cast<double>(tick));
    if (lit(board, led, tick)) sum += overlap;
  }
  return sum / (end - begin);
}

TEST(LedSchedule, IsTheBoardsRuleForEveryLed) {
  const LedBoard board{.board_id = 0b1010, .synchronised = true};
  constexpr std::array<std::pair<double, double>, 7> kExposures{{{3.25, 8.0},
                                                                 {250.9, 12.6},
                                                                 {1000.0, 0.4},
                                                                 {131071.7, 700.0},
                                                                 {262143.5, 20.0},
                                                                 {262144.0 * 7 + 65535.9, 5.5},
                                                                 {4.1e9 + 0.25, 40.0}}};
  for (const auto& [begin, duration] : kExposures) {
    for (std::size_t row = 0; row < kLedRows; ++row) {
      for (std::size_t column = 0; column < kLedColumns; ++column) {
        const std::string led = kLayout.at(row).at(column);
        const LedSchedule schedule = led_schedule(board, row, column);
        ASSERT_EQ(schedule.populated, led != "-");
        if (!schedule.populated) continue;
        ASSERT_NEAR(schedule.lit_share(begin, begin + duration), share_by_ticks(board, led, begin, begin + duration), 1e-6)
            << led << " from " << begin;
        EXPECT_EQ(schedule.fine_ring, led[0] == 'A');
      }
    }
  }
}

TEST(LedSchedule, AnUnsynchronisedBoardSaysSo) {
  EXPECT_EQ(led_schedule({.synchronised = true}, 2, 16).lit_share(5, 9), 1);
  EXPECT_EQ(led_schedule({.synchronised = false}, 2, 16).lit_share(5, 9), 0);
  EXPECT_EQ(led_schedule({.synchronised = false}, 3, 16).lit_share(5, 9), 1);
}

SceneDescription board_scene() {
  SceneDescription description = plain_scene();
  description.led_board = LedBoard{.centre_in_world_m = {0, -1, 1}, .fine_ring_brightness = 0.75};
  return description;
}

calib::CameraModel board_camera() { return calib::look_at(640, 240, 1200, {0, -3, 1}, {0, 0, 1}); }

Vec2 led_in_picture(const calib::Projection& projection, const LedBoard& board, std::size_t row, std::size_t column) {
  const Vec3& c = board.centre_in_world_m;
  return projection.project(
      {c.x + (static_cast<double>(column) - 8.5) * board.pitch_m, c.y, c.z - (static_cast<double>(row) - 1.5) * board.pitch_m});
}

double brightness(const Pixels& pixels, const Vec2& at) {
  return pixels.at(static_cast<std::size_t>(std::lround(at.x)), static_cast<std::size_t>(std::lround(at.y)));
}

// The picture of each LED is its light times the exact share of the exposure during which it is lit, wherever in its ticks the
// exposure begins, and whatever the number of taps.
TEST(LedBoard, ShowsTheExactShareOfTheExposure) {
  const auto scene = build(board_scene());
  const LedBoard& board = *scene->description().led_board;
  for (const int taps : {1, 3}) {
    CameraOptions options = clean();
    options.exposure_taps = taps;
    FrameRenderer camera = renderer(scene, board_camera(), options);
    const calib::Projection projection(camera.camera());
    for (const double start_s : {0.00013, 0.01641, 0.1271}) {
      const Pixels pixels = render(
          camera, [](double t, SceneMoment& moment) { moment.board_time_s = 77 + t; }, start_s);
      const double dark = brightness(pixels, led_in_picture(projection, board, 1, 17));
      const double full = brightness(pixels, led_in_picture(projection, board, 0, 0)) - dark;
      ASSERT_GT(full, 100);
      const double begin_ticks = (77 + start_s) / board.tick_duration_s;
      for (std::size_t row = 0; row < kLedRows; ++row) {
        for (std::size_t column = 0; column < kLedColumns; ++column) {
          const LedSchedule schedule = led_schedule(board, row, column);
          if (!schedule.populated) continue;
          const double share = schedule.lit_share(begin_ticks, begin_ticks + kExposure_s / board.tick_duration_s);
          // One count for rounding the picture to whole numbers.
          EXPECT_NEAR(brightness(pixels, led_in_picture(projection, board, row, column)) - dark, share * full, 1.1)
              << row << ", " << column << " from " << start_s;
        }
      }
    }
  }
}

TEST(LedBoard, DaylightChangesThePlateButNotTheLeds) {
  const auto scene = build(board_scene());
  FrameRenderer camera = renderer(scene, board_camera(), clean());
  const calib::Projection projection(camera.camera());
  const Vec2 fiducial = led_in_picture(projection, *scene->description().led_board, 0, 0);
  const Vec2 dark = led_in_picture(projection, *scene->description().led_board, 1, 17);
  const Pixels bright = render(camera, [](double, SceneMoment& moment) { moment.light_level = 1; });
  const Pixels dull = render(camera, [](double, SceneMoment& moment) { moment.light_level = 0.5; });
  EXPECT_NEAR(brightness(dull, dark), brightness(bright, dark) / 2, 1);
  EXPECT_NEAR(brightness(dull, fiducial) - brightness(dull, dark), brightness(bright, fiducial) - brightness(bright, dark),
              1.1);
}

// A tall LED, and rows that begin 0.1 ms after each other: each row shows the share of its own exposure.
TEST(LedBoard, RollingShutterGivesEachRowItsOwnTime) {
  SceneDescription description = board_scene();
  description.led_board->led_diameter_m = 0.05;
  const auto scene = build(description);
  CameraOptions options = clean();
  options.line_delay_s = 1e-4;
  options.band_rows = 7;
  calib::CameraModel model = calib::look_at(640, 480, 2400, {0, -3, 1}, {-0.3, 0, 1.05});
  FrameRenderer camera = renderer(scene, model, options);
  const calib::Projection projection(camera.camera());
  const LedBoard& board = *scene->description().led_board;
  const Pixels pixels = render(
      camera, [](double t, SceneMoment& moment) { moment.board_time_s = 10 + t; }, 0.02);
  const Vec2 fiducial = led_in_picture(projection, board, 0, 0);
  const double full = brightness(pixels, fiducial);
  int checked = 0;
  for (std::size_t column = 1; column < 9; ++column) {
    const Vec2 at = led_in_picture(projection, board, 0, column);
    for (double y = at.y - 20; y <= at.y + 20; y += 4) {
      const double row = std::round(y);
      const double begin_ticks = (10 + 0.02 + row * options.line_delay_s) / board.tick_duration_s;
      const double share =
          led_schedule(board, 0, column).lit_share(begin_ticks, begin_ticks + kExposure_s / board.tick_duration_s);
      const double dark = 28;  // of 255: the lens of an LED that is off
      EXPECT_NEAR(brightness(pixels, {at.x, row}), dark + share * (full - dark), 1.6) << column << " row " << row;
      checked += share > 0.01 && share < 0.99 ? 1 : 0;
    }
  }
  EXPECT_GT(checked, 10);
}

}  // namespace
}  // namespace roseau::render
