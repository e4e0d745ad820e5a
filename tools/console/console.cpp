#include "tools/console/console.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>

#include "drivers/network/address.h"
#include "palpate/core/log.h"
#include "palpate/core/run_directory.h"
#include "palpate/core/statistics.h"
#include "palpate/core/stop_signal.h"
#include "palpate/core/text.h"
#include "palpate/figures/page_file.h"
#include "palpate/record/session/device_messages.h"
#include "palpate/record/session/viewer_feed.h"
#include "palpate/render/picture_file.h"
#include "palpate/time/clock.h"
#include "palpate/time/utc.h"
#include "palpate/transport/messages.h"
#include "palpate/transport/shown_picture.h"
#include "palpate/transport/state_watch.h"
#include "palpate/transport/zmq_engine.h"
#include "palpate/web/web_guard.h"
#include "palpate/web/web_server.h"
#include "tools/console/observed_session.h"
#include "tools/console/page_messages.h"
#include "tools/console/token.h"
#include "tools/console/viewer_talk.h"

namespace palpate::tools::console {

figures::PageFiles console_files();

namespace {

constexpr Log kLog("console");
constexpr Duration kLook = std::chrono::milliseconds(4), kPageEvery = std::chrono::milliseconds(16),
                   kStatusEvery = std::chrono::milliseconds(200), kSceneEvery = std::chrono::seconds(2),
                   kPictureEvery = std::chrono::milliseconds(50);
constexpr std::size_t kMostUnsent = 256;  // states for the page

std::string_view type_of(std::string_view name) {
  if (name.ends_with(".html")) return "text/html; charset=utf-8";
  if (name.ends_with(".css")) return "text/css; charset=utf-8";
  if (name.ends_with(".js")) return "text/javascript; charset=utf-8";
  return "image/svg+xml";
}

// The moments from a state until a page had drawn it, ms: the newest.
class ShownAfter {
 public:
  void add(double ms) {
    if (times_.size() == kMost) times_.erase(times_.begin());
    times_.push_back(ms);
    ++count_;
  }
  double median() const { return times_.empty() ? 0.0 : quantile(times_, 0.5); }
  double p99() const { return times_.empty() ? 0.0 : quantile(times_, 0.99); }
  std::uint64_t count() const { return count_; }

 private:
  static constexpr std::size_t kMost = 1000;
  std::vector<double> times_;
  std::uint64_t count_ = 0;
};

class Console final : public web::WebHandler {
 public:
  explicit Console(const ConsoleOptions& options) : options_(options) {}

  Expected<Json> run();

 private:
  struct Page {
    std::uint64_t events_told = 0;
    ShownAfter shown;
  };

  std::optional<web::WebFile> file(std::string_view path) override;
  void joined(web::WebPeer& peer) override;
  void heard(web::WebPeer& peer, std::string_view bytes, bool binary) override;
  void left(web::WebPeer& peer) override;

  Expected<void> open();
  void take_states();
  void send_states();
  void look_at_status();
  void send_status();
  void send_scene();
  void send_picture(Instant<PhysicsClock> now);
  void send(Channel channel, std::uint64_t time_ns, const std::string& message);
  void send_to_page(web::WebPeer& peer, Page& page);
  void hear_page(web::WebPeer& peer, Page& page, std::string_view text);
  void carry_out(web::WebPeer& peer, const PageSaying& wish);
  bool wanted(Channel channel) const;
  std::uint64_t utc_ns(Instant<PhysicsClock> time) const {
    return static_cast<std::uint64_t>(time.ns() + to_utc_ns_);
  }
  Json figures() const;

  const ConsoleOptions& options_;
  const figures::PageFiles files_ = console_files();
  MonotonicClock<PhysicsClock> clock_;
  std::int64_t to_utc_ns_ = 0;
  std::string token_;     // empty: nobody may do anything
  bool ask_all_ = false;  // also of who only looks
  std::optional<ObservedSession> session_;
  std::optional<transport::ShownPictureReader> pictures_;  // none: they are not shown
  std::optional<Instant<PhysicsClock>> wanted_;            // was last said
  EventLog events_;
  std::map<web::WebPeer*, Page> pages_;
  std::map<web::WebPeer*, ViewerTalk> viewers_;
  std::vector<scene::SceneState> unsent_;
  ShownAfter shown_;
  std::uint64_t controls_ = 0, refused_ = 0, peers_ = 0, descriptions_ = 0, shown_pictures_ = 0;
  std::unique_ptr<web::WebServer> web_;  // gone first
};

std::optional<web::WebFile> Console::file(std::string_view path) {
  const std::string_view name = path == "/" ? "index.html" : path.substr(1);
  for (const auto& file : files_)
    if (file.name == name) return web::WebFile{type_of(name), file.text};
  return std::nullopt;
}

Expected<void> Console::open() {
  web::WebServerOptions how;
  how.address = options_.address;
  how.port = options_.port;
  how.hosts = options_.hosts;
  how.origins = options_.origins;
  how.protocols = {kPageProtocol, kViewerProtocols[0], kViewerProtocols[1]};
  const bool beyond = !web::is_loopback(how.address);
  if (beyond) how.hosts.emplace_back(web::WebGuard::kAnyNumber);
  ask_all_ = beyond || options_.look_with_token;
  auto session = ObservedSession::open(options_.server);
  if (!session) return tl::unexpected(session.error());
  session_.emplace(std::move(*session));
  auto opened = web::WebServer::open(how, *this);
  if (!opened) return tl::unexpected(opened.error());
  web_ = std::move(*opened);
  if (ask_all_ || options_.controls) {
    const auto folder = run_directory();
    if (!folder) return tl::unexpected(folder.error());
    auto token = make_token(*folder / "console_token");
    if (!token) return tl::unexpected(token.error());
    token_ = std::move(*token);
  }
  if (options_.pictures)
    if (const auto folder = run_directory()) pictures_.emplace(*folder);
  to_utc_ns_ = palpate::utc_ns() - MonotonicClock<PhysicsClock>::monotonic_ns();
  if (beyond)
    kLog.warning(
        "warning: what the console shows goes over the network as it is: whoever can listen there sees it, "
        "and the token; an SSH tunnel to this machine is safer (docs/console.md)");
  const bool all = how.address == "0.0.0.0" || how.address == "::";
  const std::string place =
      drivers::network::Address{all ? "localhost" : how.address, web_->port()}.text() + "/";
  kLog.info("the console is at http://{}{}", place, token_.empty() ? "" : "#token=" + token_);
  kLog.info("for Lichtblick and Foxglove: ws://{}{}", place, ask_all_ ? "?token=" + token_ : "");
  if (options_.ready) options_.ready();
  return {};
}

Expected<Json> Console::run() {
  stop_requested();  // from here on a signal is a request
  if (auto done = open(); !done) return tl::unexpected(done.error());
  const auto begun = clock_.now();
  Instant<PhysicsClock> next_page, next_status, next_scene, next_picture;
  const auto due = [](Instant<PhysicsClock> now, Instant<PhysicsClock>& next, Duration every) {
    if (now < next) return false;
    next = std::max(next + every, now);
    return true;
  };
  while (!stop_requested().load()) {
    const auto now = clock_.now();
    if (options_.seconds > 0.0 && to_seconds(now - begun) >= options_.seconds) break;
    web_->serve_for(kLook);
    session_->look();
    take_states();
    look_at_status();
    if (due(now, next_page, kPageEvery)) send_states();
    if (due(now, next_status, kStatusEvery)) session_->ask_status(), send_status();
    if (due(now, next_picture, kPictureEvery)) send_picture(now);
    if (due(now, next_scene, kSceneEvery) || session_->descriptions() != descriptions_) send_scene();
  }
  return figures();
}

void Console::take_states() {
  while (const auto state = session_->take_state())
    if (unsent_.size() < kMostUnsent) unsent_.push_back(*state);
}

void Console::send_states() {
  if (unsent_.empty()) return;
  const auto& newest = unsent_.back();
  if (!pages_.empty()) {
    const auto text = std::make_shared<const std::string>(states_message(unsent_));
    for (auto& [peer, page] : pages_) peer->offer(text, false);
  }
  const auto time = utc_ns(newest.time);
  if (wanted(Channel::state)) send(Channel::state, time, transport::encode(newest));
  if (wanted(Channel::plot)) send(Channel::plot, time, record::session::encode_felt_force(newest));
  if (const auto* scene = session_->scene(); scene != nullptr && wanted(Channel::frames))
    if (const auto bodies = record::session::encode_bodies(*scene, newest, time); !bodies.empty())
      send(Channel::frames, time, bodies);
  unsent_.clear();
}

void Console::look_at_status() {
  const auto before = events_.events().empty() ? 0 : events_.events().back().number;
  events_.look(session_->view());
  if (!wanted(Channel::log)) return;
  const auto now = utc_ns(clock_.now());
  for (const auto& event : events_.events())
    if (event.number > before)
      send(Channel::log, now,
           record::session::encode_log(event.level == Level::fault     ? LogLevel::error
                                       : event.level == Level::warning ? LogLevel::warning
                                                                       : LogLevel::info,
                                       event.words, now));
}

void Console::send_status() {
  for (auto& [peer, page] : pages_) send_to_page(*peer, page);
  const SystemView view = session_->view();
  if (view.status && wanted(Channel::status))
    send(Channel::status, utc_ns(clock_.now()), transport::encode(*view.status));
}

void Console::send_to_page(web::WebPeer& peer, Page& page) {
  std::vector<Event> news;
  for (const auto& event : events_.events())
    if (event.number > page.events_told) news.push_back(event);
  const PageFigures figures{.viewers = pages_.size() + viewers_.size(),
                            .states_missed = session_->states_missed(),
                            .page_dropped = peer.dropped(),
                            .shown_after_ms = page.shown.median(),
                            .controls = options_.controls};
  if (!news.empty()) page.events_told = news.back().number;
  const auto text = std::make_shared<const std::string>(status_message(session_->view(), news, figures));
  // The next status takes this one's place, but nothing takes that of news.
  if (news.empty())
    peer.offer(text, false);
  else
    peer.send(text);
}

void Console::send_scene() {
  const auto* scene = session_->scene();
  const bool changed = session_->descriptions() != descriptions_;
  descriptions_ = session_->descriptions();
  if (scene == nullptr) return;
  if (changed) {
    const auto text = std::make_shared<const std::string>(scene_message(*scene));
    for (auto& [peer, page] : pages_) peer->send(text);
  }
  const auto now = utc_ns(clock_.now());
  if (wanted(Channel::scene)) send(Channel::scene, now, record::session::encode_scene(*scene, now));
}

// The graphics server writes them only while somebody looks.
void Console::send_picture(Instant<PhysicsClock> now) {
  if (!pictures_ || !session_->of_this_machine() || (pages_.empty() && !wanted(Channel::picture))) return;
  constexpr Duration kSayAgain = std::chrono::milliseconds(500);
  if (!wanted_ || now - *wanted_ >= kSayAgain) pictures_->want(), wanted_ = now;
  const auto picture = pictures_->take();
  if (!picture) return;
  ++shown_pictures_;
  std::string jpeg = render::jpeg_bytes(picture->rgb, picture->width, picture->height);
  if (!pages_.empty()) {
    const auto bytes = std::make_shared<const std::string>(picture_message(*picture, jpeg));
    for (auto& [peer, page] : pages_) peer->offer(bytes, true);
  }
  if (wanted(Channel::picture))
    send(Channel::picture, utc_ns(now),
         record::session::encode_compressed_image(std::move(jpeg), utc_ns(now), "camera_left"));
}

bool Console::wanted(Channel channel) const {
  return std::any_of(viewers_.begin(), viewers_.end(),
                     [&](const auto& one) { return one.second.wants(channel); });
}

void Console::send(Channel channel, std::uint64_t time_ns, const std::string& message) {
  for (auto& [peer, talk] : viewers_)
    for (auto& bytes : talk.wrap(channel, time_ns, message))
      peer->offer(std::make_shared<const std::string>(std::move(bytes)), true);
}

void Console::joined(web::WebPeer& peer) {
  if (ask_all_ && !holds_token(peer.target(), token_)) {
    ++refused_;
    kLog.warning("warning: {}: without the token; turned away", one_line(peer.address()));
    return peer.close("the token is needed that the console has printed");
  }
  ++peers_;
  const auto* scene = session_->scene();
  if (peer.protocol() == kPageProtocol) {
    Page& page = pages_[&peer];
    if (scene != nullptr) peer.send(std::make_shared<const std::string>(scene_message(*scene)));
    send_to_page(peer, page);
    return;
  }
  viewers_[&peer];
  for (auto& text : ViewerTalk::greeting(scene != nullptr ? scene->application : std::string()))
    peer.send(std::make_shared<const std::string>(std::move(text)));
}

void Console::left(web::WebPeer& peer) {
  pages_.erase(&peer);
  viewers_.erase(&peer);
}

void Console::heard(web::WebPeer& peer, std::string_view bytes, bool binary) {
  if (const auto page = pages_.find(&peer); page != pages_.end()) {
    if (!binary) hear_page(peer, page->second, bytes);
    return;
  }
  const auto viewer = viewers_.find(&peer);
  if (viewer == viewers_.end()) return;
  const auto done = binary ? refused("bytes are not expected here") : viewer->second.take(bytes);
  if (!done)
    peer.offer(std::make_shared<const std::string>(ViewerTalk::status_text(done.error().message)), false);
}

void Console::hear_page(web::WebPeer& peer, Page& page, std::string_view text) {
  const PageSaying said = read_page_message(text);
  if (said.kind == PageSaying::Kind::control) return carry_out(peer, said);
  // Of a server on this machine, whose clock is ours.
  if (said.kind != PageSaying::Kind::seen || !session_->of_this_machine()) return;
  const double ms = 1e3 * to_seconds(clock_.now() - Instant<PhysicsClock>{Duration(said.seen_ns)});
  if (ms < 0.0 || ms > 60e3) return;
  page.shown.add(ms);
  shown_.add(ms);
}

void Console::carry_out(web::WebPeer& peer, const PageSaying& wish) {
  const auto say_no = [&](const std::string& words) {
    ++refused_;
    peer.offer(std::make_shared<const std::string>(refusal_message(words)), false);
  };
  if (!options_.controls)
    return say_no("this console only shows; palpate console --controls lets it do more");
  if (!same_token(wish.token, token_)) return say_no("the token is needed that the console has printed");
  static const std::map<std::string, scene::Control> known{
      {"reset", scene::Control::reset}, {"pause", scene::Control::pause}, {"resume", scene::Control::resume}};
  const auto control = known.find(wish.control);
  if (control == known.end()) return say_no("expected: reset, pause or resume");
  if (auto sent = session_->send(control->second); !sent) return say_no(sent.error().message);
  ++controls_;
  kLog.info("{}: {}", one_line(peer.address()), wish.control);
}

Json Console::figures() const {
  const auto web = web_->counters();
  return {{"peers", peers_},
          {"requests", web.requests},
          {"refused", web.refused + refused_},
          {"dropped", web.dropped},
          {"cut_off", web.cut_off},
          {"controls", controls_},
          {"pictures", shown_pictures_},
          {"states_missed", session_->states_missed()},
          {"shown_after_ms", {{"count", shown_.count()}, {"p50", shown_.median()}, {"p99", shown_.p99()}}}};
}

}  // namespace

Expected<Json> run_console(const ConsoleOptions& options) { return Console(options).run(); }

}  // namespace palpate::tools::console
