// One impact from first touch to release, by whichever law: how deep, how fast and how hard at each moment.
//
// SI; t counts from the first touch. Outside the contact there is no force; before it the speed is that of
// approach, after it that of leaving. A value; copying and asking allocate nothing. Laws: contact.h,
// hunt_crossley.h.
#pragma once

#include <variant>

#include "palpate/physics/contact.h"
#include "palpate/physics/hunt_crossley.h"

namespace palpate::physics {

class ContactCourse {
 public:
  ContactCourse(const DampedContact& law, double speed) : course_(Linear{law, speed}) {}
  explicit ContactCourse(const HuntCrossleyContact& impact) : course_(impact) {}

  double duration() const { return linear() ? linear()->law.duration() : stiffening().duration(); }
  double restitution() const { return linear() ? linear()->law.restitution() : stiffening().restitution(); }
  double penetration(double t) const {  // m
    return linear() ? linear()->speed * linear()->law.penetration(t) : stiffening().penetration(t);
  }
  double velocity(double t) const {  // m/s, positive inwards
    return linear() ? linear()->speed * linear()->law.velocity(t) : stiffening().velocity(t);
  }
  double force(double t) const {  // N, pushes apart
    return linear() ? linear()->speed * linear()->law.force(t) : stiffening().force(t);
  }
  // N s, handed over in [t0, t1]. However a contact is cut into pieces, they sum to m (1 + e) v.
  double impulse(double t0, double t1) const {
    const double mass = linear() ? linear()->law.mass() : stiffening().mass();
    return t1 > t0 ? mass * (velocity(t0) - velocity(t1)) : 0.0;
  }

 private:
  struct Linear {
    DampedContact law;  // for 1 m/s
    double speed;
  };
  const Linear* linear() const { return std::get_if<Linear>(&course_); }
  const HuntCrossleyContact& stiffening() const { return std::get<HuntCrossleyContact>(course_); }

  std::variant<Linear, HuntCrossleyContact> course_;
};

}  // namespace palpate::physics
