// A process that crashes says in one line whose code it was running, and takes forces away first.
//
// For SIGSEGV, SIGBUS, SIGFPE, SIGILL and SIGABRT (an exception where none may be thrown ends there): a last act,
// a line on standard error, and then the end that the signal has anyway, core file included. Where a thread has
// overrun its stack there is room for this only if the thread has called give_crash_stack().
#pragma once

namespace palpate::inline core {

// From now on. `last_act` is called first, in the thread that crashed, once: it may neither lock nor allocate.
// Null takes it away again.
void say_crashes(void (*last_act)(void* context) noexcept, void* context);

// The calling thread: a stack of its own for the case that it overruns the one it has. Allocates, once a thread.
void give_crash_stack();

}  // namespace palpate::inline core
