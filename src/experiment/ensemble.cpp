#include "piste/experiment/ensemble.h"

#include <algorithm>
#include <condition_variable>
#include <cstring>
#include <exception>
#include <functional>
#include <map>
#include <mutex>
#include <thread>
#include <utility>
#include <variant>

#include "piste/core/error.h"

namespace piste {
namespace {

using Result = std::variant<ComparedRun, FailedRun>;

Result run_one(const Scenario& scenario, std::uint64_t seed, const BatchSolver& batch) {
  try {
    return run_trial(scenario, seed, batch);
  } catch (const DataError& e) {
    return FailedRun{seed, e.what()};
  }
}

void add(Consistency& sums, Result&& result) {
  if (const auto* run = std::get_if<ComparedRun>(&result)) {
    sums.add(*run);
  } else {
    sums.add_failure(std::get<FailedRun>(std::move(result)));
  }
}

std::uint64_t hash(std::string_view bytes) { return std::hash<std::string_view>{}(bytes); }

}  // namespace

Ensemble::Ensemble(Scenario scenario, BatchSolver batch)
    : scenario_(std::move(scenario)), batch_(std::move(batch)), sums_(epoch_grid(scenario_)) {}

void Ensemble::run(std::size_t runs, std::size_t jobs, const Observer& observer) {
  jobs = std::min(jobs, runs - std::min(runs, size()));
  std::mutex mutex;
  std::condition_variable moved;
  std::map<std::size_t, Result> waiting;  // until those before them are done
  std::exception_ptr stopped;
  std::size_t next = size();
  const std::size_t most = 2 * jobs;  // trials that run or wait: memory does not grow with the number of runs
  const auto work = [&] {
    std::unique_lock lock(mutex);
    while (true) {
      moved.wait(lock, [&] { return stopped || next >= runs || next < size() + most; });
      if (stopped || next >= runs) return;
      const std::size_t mine = next++;
      try {
        lock.unlock();
        Result result = run_one(scenario_, scenario_.seed + mine, batch_);
        lock.lock();
        waiting.emplace(mine, std::move(result));
        for (auto it = waiting.begin(); !stopped && it != waiting.end() && it->first == size();) {
          add(sums_, std::move(it->second));
          it = waiting.erase(it);
          if (size() == 1) first_ = hash(sums_.save());
          if (observer) observer(*this);
        }
      } catch (...) {  // of the trial or of the observer: out of a thread it would end the program
        if (!lock.owns_lock()) lock.lock();
        if (!stopped) stopped = std::current_exception();
      }
      moved.notify_all();
    }
  };
  {
    std::vector<std::jthread> others;
    for (std::size_t i = 1; i < jobs; ++i) others.emplace_back(work);
    work();
  }
  if (stopped) std::rethrow_exception(stopped);
}

std::string Ensemble::save() const {
  std::string bytes(sizeof first_, '\0');
  std::memcpy(bytes.data(), &first_, sizeof first_);
  return bytes + sums_.save();
}

bool Ensemble::resume(std::string_view bytes) {
  std::uint64_t first = 0;
  if (bytes.size() < sizeof first) return false;
  std::memcpy(&first, bytes.data(), sizeof first);
  Consistency one(epoch_grid(scenario_));
  add(one, run_one(scenario_, scenario_.seed, batch_));
  if (hash(one.save()) != first) return false;
  try {
    sums_ = Consistency::restore(bytes.substr(sizeof first));
  } catch (const DataError&) {
    return false;
  }
  first_ = first;
  return true;
}

}  // namespace piste
