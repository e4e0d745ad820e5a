#include "tools/console/observed_session.h"

#include "palpate/core/text.h"
#include "palpate/transport/zmq_engine.h"

namespace palpate::tools::console {

Expected<ObservedSession> ObservedSession::open(const transport::ServerName& server) {
  ObservedSession session;
  auto place = transport::server_place(server);
  if (!place) return tl::unexpected(place.error());
  session.place_ = std::move(*place);
  session.of_this_machine_ = session.place_.endpoint.address.starts_with("ipc://");
  auto link =
      transport::connect_states(session.place_.endpoint, *session.clock_, "console", session.place_.identity);
  if (!link) return tl::unexpected(link.error());
  session.link_ = std::move(*link);
  auto watch = transport::watch_states(session.place_.endpoint, kRate_hz, session.place_.identity);
  if (!watch) return tl::unexpected(watch.error());
  session.watch_ = std::move(*watch);
  return session;
}

void ObservedSession::look() {
  link_->poll();
  // What the one before has said is no longer so.
  if (link_->session() != session_) session_ = link_->session(), statuses_before_ = link_->statuses();
}

std::optional<scene::SceneState> ObservedSession::take_state() {
  const auto reply = watch_->take();
  if (!reply || !reply->answer.usable()) return std::nullopt;
  return reply->answer.state;
}

SystemView ObservedSession::view() const {
  SystemView view;
  view.server_answers = link_->peer_alive();
  if (const auto trouble = link_->trouble())
    view.trouble = *trouble;
  else if (!view.server_answers && link_->refusal())
    view.trouble = excerpt(*link_->refusal(), 200);
  else if (!view.server_answers)
    view.trouble = "at " + place_.endpoint.address + "; start `palpate physics`";
  if (view.server_answers && link_->statuses() > statuses_before_) view.status = link_->status();
  return view;
}

Expected<void> ObservedSession::send(scene::Control control) {
  if (!link_->peer_alive()) return refused("no physics server answers; start `palpate physics` first");
  if (link_->role() != transport::Role::operator_)
    return refused(
        "this machine's key has not the role operator there; there, `palpate keys authorize` gives it");
  if (!link_->send_control(control)) return refused("too many wishes wait for an answer; wait for it");
  return {};
}

}  // namespace palpate::tools::console
