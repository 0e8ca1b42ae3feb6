#pragma once
/// The article of the shipped campaign, whose sensors are StudyCase's.

#include "piste/study/article.h"
#include "support/places.h"

namespace piste::test {

inline ArticleBeside bonnaz_2008() {
  return {read_article(source_folder() + "/config/articles/bonnaz_2008.yaml"),
          {{"MT-9A 1", 0}, {"MT-9A 2", 1}, {"MT-9A 3", 2}}};
}

}  // namespace piste::test
