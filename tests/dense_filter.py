"""The Kalman filter with whole matrices, as in any textbook: what filters with fewer operations are held against."""

import numpy as np


def predict_n(mean, covariance, transition, noise):
    """Mean and covariance after a linear step: F x, F P F' + Q."""
    return np.dot(transition, mean), np.dot(np.dot(transition, covariance), transition.T.copy()) + noise


def update_n(mean, covariance, observation, innovation, measurement_variance):
    """Mean and covariance after one scalar measurement with row `observation`, Joseph form."""
    g = np.dot(covariance, observation)
    S = np.dot(observation, g) + measurement_variance
    k = g / S
    left = np.eye(mean.size) - np.outer(k, observation)
    P = np.dot(np.dot(left, covariance), left.T.copy()) + measurement_variance * np.outer(k, k)
    return mean + innovation * k, 0.5 * (P + P.T)
