"""The papers on trial: committed verdicts on equations and laws, printed numbers computed anew, what follows."""
