#include "plica/core/threads.hpp"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <thread>
#include <vector>

#include "plica/core/error.hpp"

namespace plica {
namespace {

using Work = std::function<void(std::ptrdiff_t, std::ptrdiff_t, std::ptrdiff_t)>;

std::atomic<int> wanted_threads{1};

/// One call of for_chunks; whoever takes part draws the next chunk until none is left.
struct Job {
  std::ptrdiff_t n, size, chunks;
  const Work& work;
  std::atomic<std::ptrdiff_t> next{0};

  void drain() {
    for (;;) {
      const std::ptrdiff_t chunk = next.fetch_add(1, std::memory_order_relaxed);
      if (chunk >= chunks) return;
      work(chunk * size, std::min(n, (chunk + 1) * size), chunk);
    }
  }
};

void pause() {
#if defined(__x86_64__) && defined(__GNUC__)
  __builtin_ia32_pause();
#else
  std::this_thread::yield();
#endif
}

/// Sleeping workers that help the calling thread. The caller never waits for a worker that has not
/// joined its job, so that a job ends whether or not workers wake up (or exist: after a fork they do not).
class Pool {
 public:
  /// Never destroyed: workers may sleep on it until the process has ended.
  static Pool& instance() {
    static Pool* const pool = new Pool;
    return *pool;
  }

  /// False, with nothing done, where another call has the workers (a second thread, or a nested call).
  bool run(Job& job, int helpers) {
    if (busy_.exchange(true, std::memory_order_acquire)) return false;
    const struct Release {
      std::atomic<bool>& flag;
      ~Release() { flag.store(false, std::memory_order_release); }
    } release{busy_};
    while (static_cast<int>(workers_.size()) < helpers) workers_.emplace_back([this] { serve(); });
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      job_ = &job;
      seats_ = helpers;
      generation_.fetch_add(1, std::memory_order_release);
    }
    for (int i = 0; i < helpers; ++i) wake_.notify_one();
    job.drain();
    std::unique_lock<std::mutex> lock(mutex_);
    job_ = nullptr;
    if (active_.load(std::memory_order_relaxed) != 0) {
      lock.unlock();
      for (int i = 0; i < spins && active_.load(std::memory_order_acquire) != 0; ++i) pause();
      lock.lock();
      done_.wait(lock, [this] { return active_.load(std::memory_order_relaxed) == 0; });
    }
    return true;
  }

 private:
  static constexpr int spins = 500;  // some microseconds: the gap between two loops of a solver

  [[noreturn]] void serve() {
    std::uint64_t seen = 0;
    for (;;) {
      for (int i = 0; i < spins && generation_.load(std::memory_order_acquire) == seen; ++i) pause();
      std::unique_lock<std::mutex> lock(mutex_);
      wake_.wait(lock, [&] { return generation_.load(std::memory_order_relaxed) != seen; });
      seen = generation_.load(std::memory_order_relaxed);
      if (job_ == nullptr || seats_ == 0) continue;
      --seats_;
      active_.fetch_add(1, std::memory_order_relaxed);
      Job& job = *job_;
      lock.unlock();
      job.drain();
      lock.lock();
      if (active_.fetch_sub(1, std::memory_order_release) == 1) done_.notify_one();
    }
  }

  std::atomic<bool> busy_{false};
  std::mutex mutex_;  // guards job_, seats_ and the changes of generation_ and active_
  std::condition_variable wake_, done_;
  Job* job_ = nullptr;
  int seats_ = 0;
  std::atomic<int> active_{0};
  std::atomic<std::uint64_t> generation_{0};
  std::vector<std::thread> workers_;
};

}  // namespace

void set_threads(int count) {
  if (count < 1 || count > 1024) throw InvalidInput("set_threads", "count", count, "", "in [1, 1024]");
  wanted_threads.store(count, std::memory_order_relaxed);
}

int threads() { return wanted_threads.load(std::memory_order_relaxed); }

void for_chunks(std::ptrdiff_t n, std::ptrdiff_t size, const Work& work) {
  if (size < 1) throw InvalidInput("for_chunks", "size", static_cast<double>(size), "", ">= 1");
  if (n <= 0) return;
  Job job{n, size, (n - 1) / size + 1, work};
  const int helpers = static_cast<int>(std::min<std::ptrdiff_t>(threads(), job.chunks)) - 1;
  if (helpers < 1 || !Pool::instance().run(job, helpers)) job.drain();
}

}  // namespace plica
