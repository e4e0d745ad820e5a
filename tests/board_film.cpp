// Pictures of a printed board as a webcam in somebody's hand takes them, for tests of the program.
//
//   board_film views BOARD.toml FOLDER COUNT     PNGs, tilted all ways, for the lens
//   board_film film BOARD.toml FILE.mp4 TIMES    four seconds over the desk, so many times; in the
//                                                last second of each it looks away
//   board_film away BOARD.toml FILE.mp4 TIMES    the board is never seen
//   board_film still BOARD.toml FOLDER SECONDS    a camera that stands, as `palpate camera record` writes its pictures
#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>
#include <numbers>

#include "palpate/core/file.h"
#include "palpate/math/looking.h"
#include "palpate/render/picture_file.h"
#include "palpate/rig/rig.h"
#include "palpate/vision/synthetic_board.h"
#include "palpate/vision/synthetic_charuco.h"

namespace {

using namespace palpate;

// tests/program/webcam_test.py knows it too.
const device::CameraModel kLens{640, 480, 610.0, 611.0, 322.0, 236.0, {-0.08, 0.03, 0.001, -0.0005, 0.0}};
constexpr double kRate = 10.0, kRound_s = 4.0, kNoise = 2.0;

std::vector<std::uint8_t> rgb_of(const std::vector<std::uint8_t>& grey) {
  std::vector<std::uint8_t> rgb;
  for (const auto value : grey) rgb.insert(rgb.end(), 3, value);
  return rgb;
}

int fail(const std::string& why) {
  fmt::print(stderr, "board_film: {}\n", why);
  return 1;
}

int views(const device::CharucoBoard& board, const std::filesystem::path& folder, int count) {
  const vision::synthetic::CharucoCamera camera(kLens, board);
  Random random(5, "views of a board");
  vision::BoardShape inner{board.columns - 1, board.rows - 1, board.square};
  for (int i = 0; i < count; ++i) {
    const auto X = vision::synthetic::board_in_view(kLens, inner, random);
    if (auto done = render::write_png(folder / fmt::format("view_{:02}.png", i),
                                      rgb_of(camera.grey(X, kNoise, random)), kLens.width, kLens.height);
        !done)
      return fail(done.error().message);
  }
  return 0;
}

int film(const device::CharucoBoard& board, const std::filesystem::path& file, int times, bool away) {
  const vision::synthetic::CharucoCamera camera(kLens, board, 2);
  Random random(6, "film of a board");
  const rig::Rig rig = rig::desk_rig(board);
  const auto& placed = *rig.board;
  const Vector3 middle = (placed.X_world_board * Point<Board>{board.middle()}).m;
  std::vector<std::vector<std::uint8_t>> pictures;
  for (int i = 0; i < static_cast<int>(kRound_s * kRate); ++i) {
    const double t = i / kRate, turn = 2.0 * std::numbers::pi * t / kRound_s;
    const Vector3 eye = middle + Vector3(0.12 * std::sin(turn), 0.60 + 0.03 * std::cos(turn), 0.62);
    const bool looks_away = away || t > kRound_s - 1.0;
    const Vector3 at = looks_away ? Vector3(middle + Vector3(1.5, 0.0, -0.3))
                                  : Vector3(middle + Vector3(0.02 * std::sin(2 * turn), 0.0, -0.16));
    const auto X = looking(eye, at).inverse() * placed.X_world_board;
    pictures.push_back(rgb_of(camera.grey(X, kNoise, random)));
  }
  auto video = render::VideoFile::create(file, kLens.width, kLens.height, kRate);
  if (!video) return fail(video.error().message);
  for (int round = 0; round < times; ++round)
    for (const auto& picture : pictures) video->add(picture);
  if (auto done = video->close(); !done) return fail(done.error().message);
  return 0;
}

// One picture, again and again: a recording of any length that is soon made.
int still(const device::CharucoBoard& board, const std::filesystem::path& folder, int seconds) {
  const vision::synthetic::CharucoCamera camera(kLens, board, 2);
  Random random(7, "picture of a board");
  const rig::Rig rig = rig::desk_rig(board);
  const auto& placed = *rig.board;
  const Vector3 middle = (placed.X_world_board * Point<Board>{board.middle()}).m;
  const auto X = looking(middle + Vector3(0.0, 0.50, 0.50), middle + Vector3(0.03, 0.02, 0.04)).inverse() *
                 placed.X_world_board;
  std::string stamps = "image,time_s\n";
  for (int i = 0; i < static_cast<int>(seconds * kRate); ++i)
    stamps += fmt::format("desk.png,{:.3f}\n", i / kRate);
  if (auto done = write_file(folder / "stamps.csv", stamps); !done) return fail(done.error().message);
  if (auto done = render::write_png(folder / "desk.png", rgb_of(camera.grey(X, kNoise, random)), kLens.width,
                                    kLens.height);
      !done)
    return fail(done.error().message);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 5) return fail("views|film|away|still BOARD.toml PLACE COUNT are expected");
  const auto board = device::read_charuco_board(argv[2]);
  if (!board) return fail(board.error().message);
  const std::string what = argv[1];
  const int count = std::atoi(argv[4]);
  if (what == "still") return still(*board, argv[3], count);
  return what == "views" ? views(*board, argv[3], count) : film(*board, argv[3], count, what == "away");
}
