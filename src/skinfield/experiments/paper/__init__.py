"""The paper's experiments, figure by figure."""
