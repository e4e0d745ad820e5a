// The drivers that a program has, each under the scheme of the devices it opens: "openhaptics:Left" is opened by the
// driver "openhaptics". Drivers add themselves (`add_to` in drivers/*/driver.h); a program fills a registry once and
// hands it to its servers, which know no other way to a device.
//
// A registry is filled in one thread; from then on it is read, from any thread. Errors: add() throws for a driver that
// cannot be used, as a broken set-up. Wrong use: a text that names no device; refused: a device that cannot be had,
// whatever a guest throws included.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/device/arm_model.h"
#include "palpate/device/camera_settings.h"
#include "palpate/device/opened.h"

namespace palpate::device {

// What each kind of device is asked for with. `uri` is SCHEME or SCHEME:REST; what the rest means the driver
// says.
struct ArmRequest {
  std::string uri;
  ArmModel nominal;                // the maker's
  bool at_reset_position = false;  // a person says so: encoders that have lost their zero may be set
};

struct TrackerRequest {
  std::string uri;
  std::vector<std::string> tools;  // MARKER=NAME, where its names are not ours
};

struct CameraRequest {
  std::string uri;
  CameraSettings settings;
};

struct HandRequest {
  std::string uri;
};

struct DisplayRequest {
  std::string uri;
};

// How a driver opens one kind of device.
template <typename R, typename O>
struct Opener {
  using Request = R;
  using Opened = O;
  // How a person names one, for messages and help: "aravis[:NAME]". Empty: it is not offered.
  std::string form;
  // Whether a text of its scheme names a device; empty: each does.
  std::function<bool(std::string_view uri)> names{};
  // Wrong use, found before anything is opened; empty: the scheme alone decides.
  std::function<Expected<void>(const Request&)> check{};
  std::function<Expected<std::unique_ptr<Opened>>(const Request&)> open;
};
using ArmOpener = Opener<ArmRequest, OpenedArm>;
using TrackerOpener = Opener<TrackerRequest, OpenedTracker>;
using CameraOpener = Opener<CameraRequest, OpenedCamera>;
using HandOpener = Opener<HandRequest, OpenedHand>;
using DisplayOpener = Opener<DisplayRequest, OpenedDisplay>;

// A camera that answers where somebody asks which there are.
struct FoundCamera {
  Json facts;        // `camera` is the text that opens it
  std::string line;  // for a person
};

struct Driver {
  std::string scheme;   // lower-case letters, digits and '-', a letter first
  std::string summary;  // one line for a person
  std::optional<ArmOpener> arm{};
  std::optional<TrackerOpener> tracker{};
  std::optional<CameraOpener> camera{};
  std::optional<HandOpener> hand{};
  std::optional<DisplayOpener> display{};
  bool simulated = false;  // its devices are computed
  bool recording = false;  // ... play what was recorded
  bool own_clock = false;  // ... stamp by clocks of their own, each by another
  // Asks which cameras there are; may take a second. Empty: it cannot know.
  std::function<std::vector<FoundCamera>()> find_cameras{};
};

// Which devices a person may choose from: all, or those that are there to be touched.
enum class Offer : std::uint8_t { all, real };

// "openhaptics" of "openhaptics:Left".
std::string_view scheme_of(std::string_view uri);
// "Left" of it; empty without a colon.
std::string_view rest_of(std::string_view uri);

class DriverRegistry {
 public:
  static constexpr std::size_t kLongestScheme = 32;

  // Throws std::invalid_argument, which names the driver: a scheme that is none or is taken, a summary of no
  // or several lines, no device of any kind, a device that cannot be opened.
  void add(Driver driver);

  // Null where there is none. Valid until the next add().
  const Driver* find(std::string_view scheme) const;
  // Of the device that a text names.
  const Driver* find_for(std::string_view uri) const { return find(scheme_of(uri)); }
  const std::vector<Driver>& drivers() const { return drivers_; }  // in the order they were added

  // What may be named where a device of this kind is expected: "lab, openhaptics or openhaptics:NAME".
  std::string arm_forms(Offer offer = Offer::all) const;
  std::string tracker_forms(Offer offer = Offer::all) const;
  std::string camera_forms(Offer offer = Offer::all) const;
  // Whether a text names one.
  bool names_arm(std::string_view uri, Offer offer = Offer::all) const;
  bool names_tracker(std::string_view uri, Offer offer = Offer::all) const;
  bool names_camera(std::string_view uri, Offer offer = Offer::all) const;

  // Wrong use, as far as it can be known without opening anything: "is 'x'; FORMS is expected".
  Expected<void> check(const ArmRequest& request) const;
  Expected<void> check(const TrackerRequest& request) const;
  Expected<void> check(const CameraRequest& request) const;

  // check() is done first.
  Expected<std::unique_ptr<OpenedArm>> open(const ArmRequest& request) const;
  Expected<std::unique_ptr<OpenedTracker>> open(const TrackerRequest& request) const;
  Expected<std::unique_ptr<OpenedCamera>> open(const CameraRequest& request) const;
  Expected<std::unique_ptr<OpenedHand>> open(const HandRequest& request) const;
  Expected<std::unique_ptr<OpenedDisplay>> open(const DisplayRequest& request) const;

 private:
  std::vector<Driver> drivers_;
};

}  // namespace palpate::device
