#include "palpate/evaluation/studies/repeats.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <vector>

#include "palpate/core/random.h"

namespace palpate::evaluation::studies {

void repeat(std::size_t count, const RepeatSettings& settings, const std::function<void(std::size_t)>& run) {
  if (settings.threads < 0) throw std::invalid_argument("repeats: the number of threads is not negative");
  if (count == 0) return;
  const std::size_t cores = std::max(1u, std::thread::hardware_concurrency());
  const std::size_t threads =
      std::min(count, settings.threads == 0 ? cores : static_cast<std::size_t>(settings.threads));
  std::atomic<std::size_t> next{0}, done{0};
  std::mutex mutex;
  std::condition_variable finished;
  std::size_t running = threads;
  std::exception_ptr error;
  {
    std::vector<std::jthread> workers;
    for (std::size_t k = 0; k < threads; ++k) {
      workers.emplace_back([&] {
        try {
          for (std::size_t i = next++; i < count; i = next++) {
            run(i);
            ++done;
          }
        } catch (...) {
          next = count;
          const std::lock_guard lock(mutex);
          if (!error) error = std::current_exception();
        }
        const std::lock_guard lock(mutex);
        --running;
        finished.notify_one();
      });
    }
    const auto report = [&] {
      if (settings.progress) settings.progress(static_cast<double>(done.load()) / static_cast<double>(count));
    };
    std::unique_lock lock(mutex);
    while (!finished.wait_for(lock, std::chrono::milliseconds(200), [&] { return running == 0; })) {
      lock.unlock();
      report();
      lock.lock();
    }
    lock.unlock();
    report();
  }
  if (error) std::rethrow_exception(error);
}

std::uint64_t repeat_seed(std::uint64_t seed, std::string_view purpose, std::size_t index) {
  Random start(seed, purpose);
  return Random(start.bits() + static_cast<std::uint64_t>(index), purpose).bits();
}

}  // namespace palpate::evaluation::studies
