#include "files/photographs.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>

#include "piste/math/units.h"
#include "support/random.h"

namespace piste::test {
namespace {

// A camera on a body: its axes look along the body's by roll, pitch and heading.
PlacedPoint camera_on(const Vector3d& body, const Vector3d& boresight) {
  const Quaterniond q = from_euler(kDegree * body) * from_euler(kDegree * boresight);
  return {1, {{0.8, 0.13, 500}, Vector3d::Zero(), to_euler(q.toRotationMatrix())}, NavigationCovariance::Zero()};
}

Vector3d degrees_of(const PlacedPoint& camera) { return kDegreesPerRadian * image_angles(camera).angles; }

// What a photogrammetrist knows by heart. Downwards: the top of the image is where the body looks.
TEST(Photographs, AnglesOfCamerasThatOneKnows) {
  const Vector3d down(0, -89.999999, 0), ahead(0, 0, 0);
  constexpr double kNear = 1e-5;
  EXPECT_LT(degrees_of(camera_on({0, 0, 0}, down)).norm(), kNear);
  EXPECT_LT((degrees_of(camera_on({0, 0, 90}, down)) - Vector3d(0, 0, -90)).norm(), kNear);
  EXPECT_LT((degrees_of(camera_on({0, 0, -30}, down)) - Vector3d(0, 0, 30)).norm(), kNear);
  // The right wing down, heading north: the camera looks to the left of the track, to the west. Its image turns about
  // north, by φ; the nose up: about east, by ω.
  EXPECT_LT((degrees_of(camera_on({10, 0, 0}, down)) - Vector3d(0, 10, 0)).norm(), kNear);
  EXPECT_LT((degrees_of(camera_on({0, 10, 0}, down)) - Vector3d(10, 0, 0)).norm(), kNear);
  // Upright, towards the north: its back is south, ω = 90°.
  EXPECT_LT((degrees_of(camera_on({0, 0, 0}, ahead)) - Vector3d(90, 0, 0)).norm(), kNear);
}

// The image's axes in east, north, up, by the camera's own.
TEST(Photographs, AnglesMakeTheRotation) {
  Random random(12);
  for (int i = 0; i < 200; ++i) {
    const PlacedPoint camera = camera_on(random.vector(60), random.vector(60));
    const Matrix3d R_nc = from_euler(camera.navigation.euler).toRotationMatrix();
    const auto enu = [](const Vector3d& n) { return Vector3d(n.y(), n.x(), -n.z()); };
    Matrix3d expected;
    expected << enu(R_nc.col(1)), enu(-R_nc.col(2)), enu(-R_nc.col(0));
    const Vector3d a = image_angles(camera).angles;
    const Matrix3d R = (Eigen::AngleAxisd(a.x(), Vector3d::UnitX()) * Eigen::AngleAxisd(a.y(), Vector3d::UnitY()) *
                        Eigen::AngleAxisd(a.z(), Vector3d::UnitZ()))
                           .toRotationMatrix();
    EXPECT_LT((R - expected).norm(), 1e-9) << i;
  }
}

// The sigmas are those of the angles of disturbed attitudes.
TEST(Photographs, SigmasOfAnglesAreThoseOfDraws) {
  Random random(13);
  for (const Vector3d& boresight : {Vector3d(0, -80, 0), Vector3d(3, -40, 20), Vector3d(0, 0, 0)}) {
    PlacedPoint camera = camera_on({5, -8, 70}, boresight);
    const Matrix3d factor = 1e-4 * (Matrix3d::Identity() + 0.4 * random.matrix(3, 3));
    camera.covariance.block<3, 3>(6, 6) = factor * factor.transpose();
    const ImageAngles about = image_angles(camera);
    Vector3d squares = Vector3d::Zero();
    constexpr int kDraws = 4000;
    for (int i = 0; i < kDraws; ++i) {
      PlacedPoint drawn = camera;
      drawn.navigation.euler += factor * random.vector();
      squares += (image_angles(drawn).angles - about.angles).cwiseAbs2();
    }
    const Vector3d ratio = (squares / kDraws).cwiseSqrt().cwiseQuotient(about.sigmas);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(ratio[k], 1, 5 / std::sqrt(2.0 * kDraws)) << boresight.transpose();
  }
}

TEST(Photographs, Texts) {
  PlacedPoint camera = camera_on({0, 0, -30}, {0, -89.999999, 0});
  camera.covariance.diagonal().head<3>() << 0.0004, 0.0009, 0.0016;
  const std::vector<PlacedMark> marks{{"a, b.jpg", camera}};
  EXPECT_EQ(pix4d_text(marks),
            "#imagename,latitude,longitude,altitude,omega,phi,kappa,accuracy horizontal,accuracy vertical\n"
            "\"a, b.jpg\",45.8366236105,7.4484513367,500.0000,0.000001,0.000000,30.000000,0.0300,0.0400\n");
  const std::string text = metashape_text(marks);
  EXPECT_NE(text.find("\n\"a, b.jpg\",7.4484513367,45.8366236105,500.0000,0.0300,0.0200,0.0400,0.000001,0.000000,30."),
            std::string::npos)
      << text;
}

}  // namespace
}  // namespace piste::test
