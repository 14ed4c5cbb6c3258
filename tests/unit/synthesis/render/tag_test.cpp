#include <gtest/gtest.h>

extern "C" {
#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>
}

#include <cmath>
#include <map>
#include <numbers>

#include "render_support.h"
#include "synthesis/render/vector_math.h"

namespace roseau::render {
namespace {

using namespace render::testing;  // NOLINT(google-build-using-namespace)

struct Detection {
  Vec2 centre;
  std::array<Vec2, 4> corners;
};

// libapriltag counts from a pixel's corner: half a pixel more than everyone else.
std::map<int, Detection> detect(Pixels& pixels) {
  const std::unique_ptr<apriltag_family_t, void (*)(apriltag_family_t*)> family(tag36h11_create(), tag36h11_destroy);
  const std::unique_ptr<apriltag_detector_t, void (*)(apriltag_detector_t*)> detector(apriltag_detector_create(),
                                                                                      apriltag_detector_destroy);
  apriltag_detector_add_family(detector.get(), family.get());
  detector->quad_decimate = 1;
  const auto width = static_cast<int>(pixels.width);
  image_u8_t image{.width = width,
                   .height = static_cast<int>(pixels.bytes.size()) / width,
                   .stride = width,
                   .buf = reinterpret_cast<std::uint8_t*>(pixels.bytes.data())};
  zarray_t* found = apriltag_detector_detect(detector.get(), &image);
  std::map<int, Detection> detections;
  for (int i = 0; i < zarray_size(found); ++i) {
    apriltag_detection_t* detection = nullptr;
    zarray_get(found, i, static_cast<void*>(&detection));
    Detection& kept = detections[detection->id];
    kept.centre = {detection->c[0] - 0.5, detection->c[1] - 0.5};
    for (std::size_t corner = 0; corner < 4; ++corner) {
      kept.corners.at(corner) = {detection->p[corner][0] - 0.5, detection->p[corner][1] - 0.5};
    }
  }
  apriltag_detections_destroy(found);
  return detections;
}

Quaternion product(const Quaternion& a, const Quaternion& b) {
  return {a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
          a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x, a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}

// Rig's axes: x east, y up, front to the south; then rolled about its front's normal and turned about the vertical.
Quaternion facing_south(double yaw_rad, double roll_rad = 0) {
  constexpr double kHalf = std::numbers::sqrt2 / 2;
  const Quaternion yaw{std::cos(yaw_rad / 2), 0, 0, std::sin(yaw_rad / 2)};
  const Quaternion roll{std::cos(roll_rad / 2), 0, 0, std::sin(roll_rad / 2)};
  return product(product(yaw, {kHalf, kHalf, 0, 0}), roll);
}

SceneDescription rig_scene() {
  SceneDescription description = plain_scene();
  description.background.plain = {0.5, 0.5, 0.5};
  description.bar_rig =
      BarRig{.bar_diameter_m = 0.03, .tag_size_m = 0.3, .front_tags = {17, 3, 586}, .back_tags = {100, 101, 102}};
  return description;
}

// 30 px: 0.3 m at 12 m through 1200 px.
calib::CameraModel rig_camera() { return calib::look_at(640, 480, 1200, {0.4, -12, 1.7}, {0, 0, 2.2}); }

MomentAt rig_at(double yaw_rad, const Vec3& shift, double roll_rad = 0) {
  return [yaw_rad, shift, roll_rad](double, SceneMoment& moment) {
    moment.rig.visible = true;
    moment.rig.world_from_rig = facing_south(yaw_rad, roll_rad);
    const Matrix3 turn = rotation(moment.rig.world_from_rig);
    const auto at = [&](double x, double y) { return add(shift, rotated(turn, {x, y, 0})); };
    moment.rig.targets_in_world_m = {at(-1.2, 0), at(0.5, 0.01), at(1.4, 0)};
    moment.rig.long_bar_in_world_m = {at(-1.5, -0.05), at(0, 0), at(1.6, -0.05)};
    moment.rig.cross_bar_in_world_m = {at(0.5, -0.5), at(0.5, 0.5)};
  };
}

// The detector reads single pixels along a tag's edges: with sharp pictures of edges nearly along rows or columns it errs by a
// tenth of a pixel by itself. Tilted tags and a lens with some blur leave about what the literature has for it.
TEST(Tags, AreDetectedWhereTheyStand) {
  const auto scene = build(rig_scene());
  CameraOptions options = clean();
  options.lens_blur_px = 0.7;
  FrameRenderer camera = renderer(scene, rig_camera(), options);
  const calib::Projection projection(camera.camera());
  double squares = 0;
  int checked = 0;
  for (int pose = 0; pose < 12; ++pose) {
    const MomentAt at = rig_at(0.09 * (pose - 6), {0.013 * pose, -0.2, 2.0 + 0.017 * pose}, 0.2 + 0.03 * pose);
    Pixels pixels = render(camera, at);
    const std::map<int, Detection> found = detect(pixels);
    SceneMoment moment = scene->rest();
    at(0, moment);
    for (std::size_t tag = 0; tag < 3; ++tag) {
      const int id = scene->description().bar_rig->front_tags[tag];
      ASSERT_TRUE(found.contains(id)) << id << " in pose " << pose;
      const Vec2 truth = projection.project(moment.rig.targets_in_world_m[tag]);
      EXPECT_NEAR(found.at(id).centre.x, truth.x, 0.12) << id << " in pose " << pose;
      EXPECT_NEAR(found.at(id).centre.y, truth.y, 0.12) << id << " in pose " << pose;
      squares += std::pow(found.at(id).centre.x - truth.x, 2) + std::pow(found.at(id).centre.y - truth.y, 2);
      checked += 2;
    }
    EXPECT_EQ(found.size(), 3U);
  }
  EXPECT_LT(std::sqrt(squares / checked), 0.05);
}

double area(std::span<const Vec2> polygon, Vec2& moment) {
  double twice = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec2& a = polygon[i];
    const Vec2& b = polygon[(i + 1) % polygon.size()];
    const double piece = a.x * b.y - b.x * a.y;
    twice += piece;
    moment.x += piece * (a.x + b.x) / 6;
    moment.y += piece * (a.y + b.y) / 6;
  }
  return twice / 2;
}

// Without any detector: the light of the whole tag, and where it lies on average, is that of its cells as projected.
TEST(Tags, EachCellIsDrawnWhereItIsProjected) {
  SceneDescription description = rig_scene();
  description.background.plain = {0, 0, 0};
  description.bar_rig->front_tags = {42};
  description.bar_rig->back_tags.clear();
  const auto scene = build(description);
  const TagPattern pattern = *tag36h11(42);
  for (const calib::CameraModel& model : {rig_camera(), distorting_camera()}) {
    FrameRenderer camera = renderer(scene, model, clean());
    const calib::Projection projection(model);
    for (int pose = 0; pose < 5; ++pose) {
      const Vec3 centre{0.3 + 0.011 * pose, -0.1, 1.9};
      const Quaternion attitude = facing_south(0.1 * pose);
      const Pixels pixels = render(camera, [&](double, SceneMoment& moment) {
        moment.displacement_m[1] = moment.displacement_m[2] = {0, -50, 0};  // the pole behind the camera
        moment.displacement_m[0] = {0, -50, 0};
        moment.rig.visible = true;
        moment.rig.world_from_rig = attitude;
        moment.rig.targets_in_world_m = {centre};
      });
      const auto corner = [&](std::size_t row, std::size_t column) {
        const double cell = 0.3 / 8;
        return projection.project(add(centre, rotated(rotation(attitude), {cell * (static_cast<double>(column) - 5),
                                                                           cell * (5 - static_cast<double>(row)), 0})));
      };
      Vec2 moment;
      double light = 0;
      for (std::size_t row = 0; row < 10; ++row) {
        for (std::size_t column = 0; column < 10; ++column) {
          Vec2 of_cell;
          const double white = std::round(255 * (pattern.white[row][column] ? 0.86 : 0.045));
          light += white * area(std::array{corner(row, column), corner(row, column + 1), corner(row + 1, column + 1),
                                           corner(row + 1, column)},
                                of_cell);
          moment.x += white * of_cell.x;
          moment.y += white * of_cell.y;
        }
      }
      const Vec2 at = projection.project(centre);
      const Vec2 drawn = centroid(pixels, 0, at, 60);
      EXPECT_NEAR(drawn.x, moment.x / light, 0.012) << pose;
      EXPECT_NEAR(drawn.y, moment.y / light, 0.012) << pose;
      double sum = 0;
      for (const std::byte pixel : pixels.bytes) sum += static_cast<double>(pixel);
      EXPECT_NEAR(sum / light, 1, 0.006) << pose;
    }
  }
}

// The library's corners begin at the lower left of the upright tag and go around counter-clockwise.
TEST(Tags, StandUprightAndAsLargeAsTheyAre) {
  const auto scene = build(rig_scene());
  FrameRenderer camera = renderer(scene, rig_camera(), clean());
  const calib::Projection projection(camera.camera());
  const MomentAt at = rig_at(0, {0, 0, 2});
  Pixels pixels = render(camera, at);
  const Detection tag = detect(pixels).at(3);
  SceneMoment moment = scene->rest();
  at(0, moment);
  const Vec3 c = moment.rig.targets_in_world_m[1];
  const std::array<Vec3, 4> corners{{{c.x - 0.15, c.y, c.z - 0.15},
                                     {c.x + 0.15, c.y, c.z - 0.15},
                                     {c.x + 0.15, c.y, c.z + 0.15},
                                     {c.x - 0.15, c.y, c.z + 0.15}}};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(tag.corners.at(i).x, projection.project(corners.at(i)).x, 0.25) << i;
    EXPECT_NEAR(tag.corners.at(i).y, projection.project(corners.at(i)).y, 0.25) << i;
  }
}

TEST(Tags, OnTheBackHaveTheirOwnNumbersAndAreNotMirrored) {
  const auto scene = build(rig_scene());
  FrameRenderer camera = renderer(scene, rig_camera(), clean());
  const MomentAt behind = rig_at(std::numbers::pi, {0, 0, 2}, 0.3);
  Pixels pixels = render(camera, behind);
  const std::map<int, Detection> found = detect(pixels);
  SceneMoment moment = scene->rest();
  behind(0, moment);
  const calib::Projection projection(camera.camera());
  ASSERT_EQ(found.size(), 3U);
  for (std::size_t tag = 0; tag < 3; ++tag) {
    const Vec2 truth = projection.project(moment.rig.targets_in_world_m[tag]);
    EXPECT_NEAR(found.at(100 + static_cast<int>(tag)).centre.x, truth.x, 0.12);
  }

  SceneDescription one_sided = rig_scene();
  one_sided.bar_rig->back_tags.clear();
  const auto bare = build(one_sided);
  FrameRenderer other = renderer(bare, rig_camera(), clean());
  Pixels paper = render(other, behind);
  EXPECT_TRUE(detect(paper).empty());
}

TEST(Tags, OutsideTheFamilyAreRefused) {
  SceneDescription description = rig_scene();
  description.bar_rig->front_tags = {1, 587, 2};
  EXPECT_NE(VisibleScene::create(description).error().message.find("587"), std::string::npos);
  description.bar_rig->front_tags = {1, 2, 3, 4};
  EXPECT_FALSE(VisibleScene::create(description));  // three on the back
}

}  // namespace
}  // namespace roseau::render
