#include "palpate/calibration/internal/rig_figures.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "palpate/core/units.h"
#include "palpate/math/chi_square.h"

namespace palpate::calibration {
namespace {

constexpr double kOutside = 0.05, kEachSide = 0.5 * kOutside, kDeviations = 1.96;  // 95 %
constexpr double kFigureStep = 1e-3;  // of a deviation, for derivatives
constexpr double kMsPerS = 1e3;

using Quantity = std::function<Eigen::VectorXd(const RigState&)>;

class Figures {
 public:
  Figures(const RigMisfit& misfit, const RigObservations& observed, const ChangeFit& found,
          const VerificationOptions& options)
      : misfit_(misfit), observed_(observed), found_(found), options_(options) {
    now_ = changed(misfit.rig_state(), found.changes, found.amounts);
    posterior_ = misfit.posterior(found.jacobian, misfit.differences(now_));
  }

  void arm() {
    if (observed_.held.empty()) return;
    RigFigure figure{"arm", "mm", kMillimetresPerMetre};
    observe(figure, misfit_.held(), 3);
    infer(figure, 3, split([this](const RigState& state) {
            Eigen::VectorXd tips(3 * static_cast<Eigen::Index>(observed_.held.size()));
            Eigen::Index row = 0;
            for (const auto& held : observed_.held)
              tips.segment<3>(row) = state.tip_at(held.joints).m, row += 3;
            return tips;
          }));
    list_.push_back(figure);
  }

  void places() {
    if (observed_.touched.empty()) return;
    RigFigure figure{"places", "mm", kMillimetresPerMetre};
    observe(figure, misfit_.touched(), 3);
    infer(figure, 3, split([this](const RigState& state) {
            Eigen::VectorXd places(3 * static_cast<Eigen::Index>(observed_.touched.size()));
            Eigen::Index row = 0;
            for (const auto& touched : observed_.touched)
              places.segment<3>(row) = state.place(touched).m, row += 3;
            return places;
          }));
    list_.push_back(figure);
  }

  // What is drawn and what is seen differ by the rig's error and by how a dot is found, and by nothing else.
  void picture() {
    const auto rows = misfit_.seen();
    if (rows.count == 0) return;
    RigFigure figure{"picture", "px", 1.0};
    const Eigen::MatrixXd expected = observe(figure, rows, 2);
    const Eigen::VectorXd r = misfit_.raw(misfit_.rig_state()).segment(rows.first, rows.count);
    const double own = options_.pixel_sd * options_.pixel_sd;
    double detection = 0.0, variance = 0.0;
    std::vector<Eigen::Vector2d> sums(misfit_.rig_state().landmarks.size(), Eigen::Vector2d::Zero());
    Eigen::Index row = 0;
    for (const auto& frame : observed_.frames)
      for (const auto& dot : frame.dots) {
        const Eigen::Vector2d d = r.segment<2>(row);
        row += 2;
        detection += dot.covariance.trace() + 2.0 * own;
        variance += 4.0 * d.dot(dot.covariance * d) + 2.0 * dot.covariance.squaredNorm();
        sums[dot.landmark] += d;  // what a sighting does not state is the same in all pictures of a dot
      }
    for (const auto& sum : sums) variance += 4.0 * own * sum.squaredNorm();
    const double items = 0.5 * static_cast<double>(rows.count), square = r.squaredNorm() - detection,
                 spread = kDeviations * std::sqrt(variance);
    const auto rms = [items](double sum) { return std::sqrt(std::max(0.0, sum) / items); };
    figure.error = rms(square);
    figure.low = rms(square - spread);
    figure.high = rms(square + spread);
    figure.promised = rms(expected.trace() - detection);
    figure.promised_high = figure.seen_high;
    list_.push_back(figure);
  }

  // Of each picture and pose; the tracker's noise of the picture's moment comes to the rig's error, as far as the
  // picture's dots tell it.
  void tip() {
    const auto pairs = tips_in_pictures();
    if (pairs.empty()) return;
    const Quantity pixels = [&pairs](const RigState& state) {
      Eigen::VectorXd all(2 * static_cast<Eigen::Index>(pairs.size()));
      Eigen::Index row = 0;
      for (const auto& pair : pairs) {
        all.segment<2>(row) = state.pixel(*pair.frame, state.tip_at(pair.held->joints).m)
                                  .value_or(device::Pixel(device::Pixel::Zero()));
        row += 2;
      }
      return all;
    };
    const RigState& rig = misfit_.rig_state();
    constexpr double kStep = 1e-6;  // rad, m
    const Eigen::MatrixXd by_marker =
        derivative(6, kStep, [&](const Eigen::VectorXd& step) -> Eigen::VectorXd {
          RigState state = rig;
          state.head_field += step;
          return pixels(state);
        });
    Split part = split(pixels);
    Eigen::MatrixXd stated = Eigen::MatrixXd::Zero(part.covariance.rows(), part.covariance.rows());
    const RigState likely = posterior_state();
    for (std::size_t begin = 0, end = 0; begin < pairs.size(); begin = end) {
      while (end < pairs.size() && pairs[end].frame == pairs[begin].frame) ++end;
      const auto first = 2 * static_cast<Eigen::Index>(begin),
                 count = 2 * static_cast<Eigen::Index>(end - begin);
      const Eigen::MatrixXd J = by_marker.middleRows(first, count);
      const auto step = misfit_.marker_step(*pairs[begin].frame, likely);
      part.mean.segment(first, count) -= J * step.mean;
      part.covariance.block(first, first, count, count) += J * step.covariance * J.transpose();
      stated.block(first, first, count, count) = J * pairs[begin].frame->covariance * J.transpose();
    }
    part.promised += stated;
    RigFigure figure{"tip", "px", 1.0};
    infer(figure, 2, part);
    list_.push_back(figure);
  }

  void delays() {
    const auto signed_figure = [&](const char* name, double RigState::*delay) {
      const auto part = split([delay](const RigState& state) -> Eigen::VectorXd {
        return Eigen::VectorXd::Constant(1, state.*delay);
      });
      RigFigure figure{name, "ms", kMsPerS};
      const double sd = std::sqrt(part.covariance(0, 0)), promised = std::sqrt(part.promised(0, 0));
      figure.error = part.mean[0];
      figure.low = figure.error - kDeviations * sd;
      figure.high = figure.error + kDeviations * sd;
      figure.promised = promised;
      figure.promised_high = kDeviations * promised;
      return figure;
    };
    if (!observed_.frames.empty()) list_.push_back(signed_figure("camera delay", &RigState::camera_delay));
    if (misfit_.delay().count == 0) return;
    RigFigure tracker = signed_figure("tracker delay", &RigState::tracker_delay);
    observe(tracker, misfit_.delay(), 1);
    list_.push_back(tracker);
  }

  std::vector<RigFigure> take() { return std::move(list_); }

 private:
  // What the differences are now, and what they stay below; their covariance where nothing has changed.
  Eigen::MatrixXd observe(RigFigure& figure, RigMisfit::Rows rows, Eigen::Index dimension) const {
    const Eigen::VectorXd r = misfit_.raw(misfit_.rig_state()).segment(rows.first, rows.count);
    const Eigen::Index items = rows.count / dimension;
    const Eigen::MatrixXd expected = misfit_.spread(rows.first, rows.count);
    figure.seen = std::sqrt(r.squaredNorm() / static_cast<double>(items));
    figure.seen_high = rms_interval(Eigen::VectorXd::Zero(rows.count), expected, items).high_one_sided;
    return expected;
  }

  struct Split {
    Eigen::VectorXd mean;  // of the rig's value minus the true one
    Eigen::MatrixXd covariance, promised;
  };
  Split split(const Quantity& quantity) const {
    const Eigen::Index errors = misfit_.errors();
    const Eigen::MatrixXd D = derivative(
        errors + found_.amounts.size(), kFigureStep, [&](const Eigen::VectorXd& step) -> Eigen::VectorXd {
          const RigState moved =
              changed(misfit_.rig_state(), found_.changes, found_.amounts + step.tail(found_.amounts.size()));
          return quantity(misfit_.errors_on(moved, step.head(errors)));
        });
    Split part;
    part.mean = quantity(misfit_.rig_state()) - quantity(now_) - D * posterior_.mean;
    part.covariance = D * posterior_.covariance * D.transpose();
    part.promised = D.leftCols(errors) * D.leftCols(errors).transpose();
    return part;
  }

  struct Pair {
    const HeadFrame* frame;
    const HeldStylus* held;
  };
  std::vector<Pair> tips_in_pictures() const {
    std::vector<Pair> pairs;
    const RigState& rig = misfit_.rig_state();
    const auto inside = [&rig](const device::Pixel& p) {
      return p.x() >= 0.0 && p.y() >= 0.0 && p.x() < rig.lens.width && p.y() < rig.lens.height;
    };
    for (const auto& frame : observed_.frames)
      for (const auto& held : observed_.held)
        if (const auto pixel = rig.pixel(frame, rig.tip_at(held.joints).m); pixel && inside(*pixel))
          pairs.push_back({&frame, &held});
    return pairs;
  }

  RigState posterior_state() const {
    const Eigen::Index changes = found_.amounts.size();
    return misfit_.errors_on(
        changed(misfit_.rig_state(), found_.changes, found_.amounts + posterior_.mean.tail(changes)),
        posterior_.mean.head(misfit_.errors()));
  }

  static void infer(RigFigure& figure, Eigen::Index dimension, const Split& part) {
    const Eigen::Index items = part.mean.size() / dimension;
    const auto now = rms_interval(part.mean, part.covariance, items);
    const auto promised = rms_interval(Eigen::VectorXd::Zero(part.mean.size()), part.promised, items);
    figure.error = now.rms;
    figure.low = now.low;
    figure.high = now.high;
    figure.promised = promised.rms;
    figure.promised_high = promised.high_one_sided;
  }

  const RigMisfit& misfit_;
  const RigObservations& observed_;
  const ChangeFit& found_;
  const VerificationOptions& options_;
  RigState now_;
  RigMisfit::Posterior posterior_;
  std::vector<RigFigure> list_;
};

}  // namespace

RmsInterval rms_interval(const Eigen::VectorXd& mean, const Eigen::MatrixXd& covariance, Eigen::Index items) {
  RmsInterval interval;
  const double expected = mean.squaredNorm() + covariance.trace();
  const double variance = 2.0 * covariance.squaredNorm() + 4.0 * mean.dot(covariance * mean);
  const auto rms = [items](double square) { return std::sqrt(square / static_cast<double>(items)); };
  interval.rms = interval.low = interval.high = interval.high_one_sided = rms(expected);
  constexpr double kMostDegrees = 1e6;  // beyond, there is no doubt left
  if (!(variance > 0.0) || 2.0 * expected * expected > kMostDegrees * variance) return interval;
  const double degrees = 2.0 * expected * expected / variance, unit = expected / degrees;
  interval.low = rms(unit * chi_square_quantile(kEachSide, degrees));
  interval.high = rms(unit * chi_square_quantile(kEachSide, degrees, true));
  interval.high_one_sided = rms(unit * chi_square_quantile(kOutside, degrees, true));
  return interval;
}

std::vector<RigFigure> rig_figures(const RigMisfit& misfit, const RigObservations& observed,
                                   const ChangeFit& found, const VerificationOptions& options) {
  Figures figures(misfit, observed, found, options);
  figures.arm();
  figures.places();
  figures.picture();
  figures.tip();
  figures.delays();
  return figures.take();
}

}  // namespace palpate::calibration
