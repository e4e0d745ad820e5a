#include "palpate/core/crash_words.h"

#include <signal.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstring>
#include <memory>

#include "palpate/core/guest_call.h"

namespace palpate::inline core {
namespace {

struct LastAct {
  void (*act)(void*) noexcept = nullptr;
  void* context = nullptr;
};
std::atomic<LastAct*> last_act{nullptr};
std::array<LastAct, 2> acts;  // one is set while the other may be read

const char* words_of(int signal) {
  switch (signal) {
    case SIGSEGV:
      return "touched memory that is not its own";
    case SIGBUS:
      return "touched memory that is not there";
    case SIGFPE:
      return "divided by zero";
    case SIGILL:
      return "ran what is no instruction";
    default:
      return "gave up (abort, or an exception where none may be thrown)";
  }
}

void say(const char* text) {
  [[maybe_unused]] const auto written = write(STDERR_FILENO, text, std::strlen(text));
}

void crash(int signal) {
  if (const LastAct* last = last_act.exchange(nullptr); last != nullptr && last->act != nullptr)
    last->act(last->context);
  const char* who = GuestCall::now();
  say("palpate: crashed: ");
  say(who != nullptr ? who : "the program itself");
  say(" ");
  say(words_of(signal));
  say("; forces are off\n");
  ::signal(signal, SIG_DFL);
  raise(signal);  // takes effect when this handler returns
}

}  // namespace

void say_crashes(void (*act)(void*) noexcept, void* context) {
  LastAct& free = last_act.load() == acts.data() ? acts[1] : acts[0];
  free = {act, context};
  last_act.store(&free);
  struct sigaction action {};
  action.sa_handler = crash;
  action.sa_flags = SA_ONSTACK;
  for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT}) sigaction(signal, &action, nullptr);
}

void give_crash_stack() {
  constexpr std::size_t kBytes = 64 * 1024;
  thread_local std::unique_ptr<std::byte[]> room;
  stack_t there{};
  if (room || sigaltstack(nullptr, &there) != 0 || (there.ss_flags & SS_DISABLE) == 0) return;
  room = std::make_unique<std::byte[]>(kBytes);
  stack_t stack{};
  stack.ss_sp = room.get();
  stack.ss_size = kBytes;
  sigaltstack(&stack, nullptr);
}

}  // namespace palpate::inline core
