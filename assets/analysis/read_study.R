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

# What the study planned, as codrive analyse fitted it (models.csv): the same models, in models_r.csv beside it.
models <- file.path(tables, "models.csv")
if (file.exists(models) && requireNamespace("lmerTest", quietly = TRUE)) {
  planned <- read.csv(models, na.strings = "", stringsAsFactors = FALSE)
  left_out <- read.csv(file.path(tables, "left_out.csv"), na.strings = "", stringsAsFactors = FALSE)
  key <- function(table) paste(table$participant, table$segment, table$place)
  whole <- left_out$participant[is.na(left_out$segment)]
  kept <- trials[!(trials$participant %in% whole) & !(key(trials) %in% key(left_out)), ]
  found <- data.frame()
  for (outcome in unique(planned$outcome)) {
    of <- planned[planned$outcome == outcome, ]
    covariates <- of$condition[of$kind == "covariate"]
    observed <- kept[complete.cases(kept[c(outcome, covariates)]), ]
    observed$condition <- droplevels(observed$condition)
    beside <- paste0(" + ", c(if (any(of$kind == "place")) "place", covariates), collapse = "")
    if (beside == " + ") beside <- ""
    model <- lmerTest::lmer(as.formula(paste0(outcome, " ~ 0 + condition", beside, " + (1 | participant)")), data = observed)
    names <- names(lme4::fixef(model))
    for (i in seq_len(nrow(of))) {
      weights <- if (of$kind[i] == "place") as.numeric(names == "place") else
        if (of$kind[i] == "covariate") as.numeric(names == of$condition[i]) else
        (names == paste0("condition", of$condition[i])) - (names == paste0("condition", of$reference[i]))
      row <- lmerTest::contest1D(model, weights, confint = TRUE)
      deviations <- as.data.frame(lme4::VarCorr(model))$sdcor
      found <- rbind(found, data.frame(outcome = outcome, kind = of$kind[i], condition = of$condition[i],
        reference = of$reference[i], participants = nlevels(droplevels(observed$participant)), trials = nrow(observed),
        estimate = row[["Estimate"]], se = row[["Std. Error"]], df = row[["df"]], t = row[["t value"]],
        p = row[["Pr(>|t|)"]], low = row[["lower"]], high = row[["upper"]],
        sd_participant = deviations[1], sd_residual = deviations[2],
        residual_w = shapiro.test(residuals(model))$statistic,
        residual_w_p = shapiro.test(residuals(model))$p.value))
    }
  }
  contrasts <- found$kind == "contrast"
  found$p_holm <- NA
  found$p_holm[contrasts] <- p.adjust(found$p[contrasts], "holm", n = planned$holm_tests[planned$kind == "contrast"][1])
  write.csv(found, file.path(tables, "models_r.csv"), row.names = FALSE, na = "")
  cat("\n== planned ==\n")
  print(found[c("outcome", "condition", "reference", "estimate", "se", "df", "p", "p_holm")])
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
  # Answers are in the list, too, and have no recording.
  recording <- tail(na.omit(scans$recording), 1)
  ego <- arrow::read_parquet(file.path(root, recording, "ego.parquet"))
  cat("\n", recording, ": ", nrow(ego), " ticks, mean speed of all vehicles ",
      round(mean(ego$mean_speed_mps), 3), " m/s\n", sep = "")
} else {
  cat("(install arrow to read a recording tick by tick)\n")
}
