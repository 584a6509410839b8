# Reads the data set of a study and fits mixed models: Rscript read_study.R DATASET
#
# Needs lme4; with lmerTest p values (Satterthwaite) are printed too; with arrow a recording is read tick by tick.
# Before it: codrive analyse DATASET.

arguments <- commandArgs(trailingOnly = TRUE)
if (length(arguments) != 1) stop("usage: Rscript read_study.R DATASET")
root <- arguments[1]

read_tsv <- function(path) {
  read.delim(path, na.strings = "n/a", check.names = FALSE, stringsAsFactors = FALSE, quote = "")
}
tables <- file.path(root, "derivatives", "codrive")
if (!file.exists(file.path(tables, "trials.csv"))) {
  stop(tables, ": no tables there; run: codrive analyse ", root)
}
participants <- read_tsv(file.path(root, "participants.tsv"))
trials <- read.csv(file.path(tables, "trials.csv"), na.strings = "", stringsAsFactors = FALSE)
trials <- merge(trials, participants, by.x = "participant", by.y = "participant_id")
trials <- trials[!is.na(trials$condition), ]
trials$condition <- factor(trials$condition, levels = unique(unlist(strsplit(participants$order[1], ","))))
trials$participant <- factor(trials$participant)
cat(nlevels(trials$participant), "participants,", nrow(trials), "trials\n\n")

measures <- c("mean_speed_mps", "speed_gain_mps", "time_in_range", "speed_error_mps", "reaction_s")
print(aggregate(trials[measures], by = list(condition = trials$condition), FUN = mean, na.rm = TRUE))

# One random intercept a participant; place is the order effect that the Latin square balances.
library(if (requireNamespace("lmerTest", quietly = TRUE)) "lmerTest" else "lme4", character.only = TRUE)

# A model of what was observed, or NULL, and why in words: such a model needs two conditions, two participants and more
# observations than it has numbers to find (a mean, differences between conditions, a slope, two variances).
fit <- function(title, response, terms, data) {
  cat("\n==", title, "==\n")
  observed <- data[!is.na(data[[response]]), ]
  participants <- length(unique(observed$participant))
  conditions <- length(unique(observed$condition))
  if (conditions < 2 || participants < 2 || nrow(observed) <= max(participants, conditions + 3)) {
    cat("too few observations for a model:", nrow(observed), "of", participants, "participants in", conditions,
        "conditions\n")
    return(NULL)
  }
  observed$condition <- factor(observed$condition)
  lmer(as.formula(paste(response, "~ condition", terms, "+ (1 | participant)")), data = observed)
}

for (measure in measures) {
  model <- fit(measure, measure, "+ place", trials)
  if (!is.null(model)) {
    print(summary(model)$coefficients)
    print(anova(model))
  }
}

# Reaction times, event by event (SAE J2944, 6.5.2): skewed, hence their logarithm. Times that were censored are left out here, which
# makes slow people faster than they are: reactions.csv has distributions that take account of them.
advice <- read.csv(file.path(tables, "advice.csv"), na.strings = "", stringsAsFactors = FALSE)
advice <- advice[!is.na(advice$condition) & advice$kind == "event", ]
advice$log_reaction_s <- log(advice$reaction_s)
model <- fit("reaction to each event (logarithm of seconds)", "log_reaction_s", "", advice)
if (!is.null(model)) print(summary(model)$coefficients)

if (requireNamespace("arrow", quietly = TRUE)) {
  subject <- as.character(trials$participant[1])
  scans <- read_tsv(file.path(root, subject, paste0(subject, "_scans.tsv")))
  ego <- arrow::read_parquet(file.path(root, scans$recording[nrow(scans)], "ego.parquet"))
  cat("\n", scans$recording[nrow(scans)], ": ", nrow(ego), " ticks, mean speed of all vehicles ",
      round(mean(ego$mean_speed_mps), 3), " m/s\n", sep = "")
} else {
  cat("(install arrow to read a recording tick by tick)\n")
}
