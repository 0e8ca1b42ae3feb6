#include "piste/trial/ensemble.h"

#include <algorithm>
#include <array>
#include <condition_variable>
#include <cstring>
#include <exception>
#include <map>
#include <mutex>
#include <utility>

#include "math/joining_thread.h"
#include "piste/core/error.h"
#include "piste/core/version.h"

namespace piste {
namespace {

// One trial's sums, or why there are none.
Consistency run_one(const Scenario& scenario, std::uint64_t seed, const BatchSolver& batch) {
  Consistency one(epoch_grid(scenario));
  try {
    one.add(run_trial(scenario, seed, batch));
  } catch (const DataError& e) {
    one.add_failure({seed, e.what()});
  }
  return one;
}

// FNV-1a: the same on every machine.
std::uint64_t hash(std::string_view bytes) {
  std::uint64_t sum = 14695981039346656037U;
  for (const char c : bytes) sum = (sum ^ static_cast<unsigned char>(c)) * 1099511628211U;
  return sum;
}

}  // namespace

Ensemble::Ensemble(Scenario scenario, BatchSolver batch, std::size_t first)
    : scenario_(std::move(scenario)), batch_(std::move(batch)), sums_(epoch_grid(scenario_), first) {}

std::uint64_t Ensemble::scenario_hash() const { return hash(std::string(version()) + '\n' + scenario_.text); }

void Ensemble::run(std::size_t runs, std::size_t jobs, const Observer& observer) {
  jobs = std::clamp<std::size_t>(runs - std::min(runs, size()), 1, std::max<std::size_t>(jobs, 1));
  std::mutex mutex;
  std::condition_variable moved;
  std::map<std::size_t, Consistency> waiting;  // trials that are done before an earlier one
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
        Consistency one = run_one(scenario_, scenario_.seed + first() + mine, batch_);
        lock.lock();
        waiting.emplace(mine, std::move(one));
        for (auto it = waiting.begin(); !stopped && it != waiting.end() && it->first == size();) {
          if (size() == 0) first_trial_ = hash(it->second.save());
          sums_.add(std::move(it->second));
          it = waiting.erase(it);
          if (observer) observer(*this);
        }
      } catch (...) {  // of the trial or of the observer: leaving a thread, it would end the program
        if (!lock.owns_lock()) lock.lock();
        if (!stopped) stopped = std::current_exception();
      }
      moved.notify_all();
    }
  };
  {
    std::vector<JoiningThread> others;
    for (std::size_t i = 1; i < jobs; ++i) others.emplace_back(work);
    work();
  }
  if (stopped) std::rethrow_exception(stopped);
}

std::string Ensemble::save() const {
  std::string bytes;
  for (const std::uint64_t number : {scenario_hash(), first_trial_}) {
    bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
  }
  return bytes + sums_.save();
}

Ensemble::Saved Ensemble::read(std::string_view bytes) {
  std::array<std::uint64_t, 2> hashes{};
  if (bytes.size() < sizeof hashes) throw DataError("ensemble", "these are no saved runs");
  std::memcpy(hashes.data(), bytes.data(), sizeof hashes);
  return {hashes[0], hashes[1], RangeSums::restore(bytes.substr(sizeof hashes))};
}

bool Ensemble::resume(std::string_view bytes) {
  try {
    Saved saved = read(bytes);
    if (saved.scenario != scenario_hash() || saved.sums.first() != first() || saved.sums.size() == 0) return false;
    if (hash(run_one(scenario_, scenario_.seed + first(), batch_).save()) != saved.first_trial) return false;
    sums_ = std::move(saved.sums);
    first_trial_ = saved.first_trial;
    return true;
  } catch (const DataError&) {
    return false;
  }
}

void Ensemble::append(std::string_view bytes) {
  const Saved saved = read(bytes);
  if (saved.scenario != scenario_hash()) {
    throw DataError("ensemble", "the runs are of another scenario file, or were made by another version");
  }
  if (size() == 0) first_trial_ = saved.first_trial;
  sums_.append(saved.sums);
}

}  // namespace piste
