// Strokes of ping-pong against a wall: how a bat has to be held and moved so that a ball goes to the wall and
// comes back to where the hand is.
//
// Aims by trying in thought: the flight with drag and spin, the bat's bounce with friction. World frame, SI.
// Pure after construction; any thread.
#pragma once

#include <array>
#include <vector>

#include "applications/pingpong/ball_world.h"
#include "palpate/physics/flight.h"
#include "palpate/scene/player.h"

namespace palpate::applications::pingpong {

// Bat that sends a ball from v_in to v_out (World, m/s): unit face normal towards the ball's side and speed
// along it.
struct Stroke {
  Vector3 normal = Vector3::UnitZ();
  double speed = 0.0;
};

// A ball where a bat could meet it.
struct Meeting {
  double time = 0.0;  // s
  physics::BallState ball;
};

// A path of the tip with the stylus turning on the way; `hit` s is when it meets the ball.
struct Swing {
  double begin = 0.0, hit = 0.0;  // s
  bool stroke = false;            // false: only a way, on which no ball is met
  scene::Quintic path;            // from begin on
  Quaternion rotation_from, rotation_to;

  scene::HandState at(double t) const;  // beyond the path's end it goes on steadily
  Vector3 jerk(double t) const;
  Quaternion turned(double t) const;
};

class Strokes {
 public:
  static constexpr double kFollow_s = 0.030;  // the bat keeps its speed that long after the meeting

  Strokes(const scene::SceneDescription& scene, const scene::Reach& reach,
          const scene::PlayerSettings& settings);

  Stroke stroke_for(const physics::BallState& in, const Vector3& v_out) const;
  // Back to the wall at `speed` (m/s, towards it), to a place so `high` above the table (m) and so far to the
  // right of the middle between here and where the ball is wanted back.
  Stroke aim(const physics::BallState& in, double speed, double high, double right = 0.0) const;
  // Orientation of the stylus with the bat's front along `normal`: blade above the hand, handle leaning to
  // the side as a right hand holds it.
  Quaternion hold(const Vector3& normal) const;
  Vector3 tip_for(const Vector3& ball, const Vector3& normal, const Quaternion& R) const;

  // Places of the flight of `ball` (at `from`, s) within reach after its one bounce, off the wall first where
  // it flies there; between `earliest` and `until`.
  // `bounced`: it has left the wall and touched the table since.
  std::vector<Meeting> meetings(physics::BallState ball, double from, double earliest, double until,
                                bool bounced = false) const;
  // The way from `hand` (at `now`) to a meeting, if the arm can go it and come back; `miss` is added to where
  // the tip is wanted. Speed and height are shares of the usual ones.
  std::optional<Swing> swing_to(const Meeting& meeting, double faster, double higher, double right,
                                const Vector3& miss, const scene::HandState& hand, const Quaternion& turned,
                                double now) const;
  // The same with a gentler stroke where the full one asks too much.
  std::optional<Swing> any_swing_to(const Meeting& meeting, double right, const Vector3& miss,
                                    const scene::HandState& hand, const Quaternion& turned, double now) const;
  // Back to the middle; a little faster or slower where that keeps the arm within its reach.
  scene::Quintic way_home(const scene::HandState& from) const;

  // Where the tip waits, and how it is held there.
  const Vector3& home() const { return home_; }
  const Quaternion& home_rotation() const { return home_rotation_; }
  const Vector3& up() const { return up_; }
  // From a ball to the tip of a hand that holds the bat as at home.
  Vector3 usual() const {
    return tip_for(Vector3::Zero(), home_rotation_ * Vector3::UnitY(), home_rotation_);
  }
  const physics::BallModel& model() const { return model_; }
  const std::array<physics::BouncePlane, 2>& planes() const { return planes_; }

 private:
  void choose_return();

  Vector3 bat_offset_;  // from the stylus tip, in Tip
  double ball_radius_ = 0.0;
  scene::Reach reach_;
  double max_acceleration_, max_speed_;
  physics::BallModel model_;
  physics::Bounce bat_;
  std::array<physics::BouncePlane, 2> planes_;
  Vector3 up_, near_, right_, wall_middle_, table_middle_;
  Vector3 home_, meeting_;  // of the tip; of the ball, where the bat at home would meet it
  double return_speed_ = 2.6, return_height_ = 0.30;  // towards the wall, m/s; above the table at the wall, m
  Quaternion home_rotation_;
};

}  // namespace palpate::applications::pingpong
